#pragma once

#include <cstdint>
#include <optional>

#include "voxelserver/serve/http/message.hpp"

namespace terravox::http {

/// What a Server serves: answers requests without knowing of sockets. Thread-safe.
class RequestHandler {
public:
    RequestHandler() = default;
    RequestHandler(const RequestHandler&) = delete;
    RequestHandler& operator=(const RequestHandler&) = delete;
    virtual ~RequestHandler() = default;

    /// Checks the head of a request, without its body. Must be called before the body is read:
    /// bodies of unauthorised requests are not read.
    /// @return the reply to send; nullopt when the body (of as many bytes as the head declares)
    /// should be read and handle() be called with it
    [[nodiscard]] virtual std::optional<Response> refusal(const Request& request) = 0;

    /// @throws only when there is not enough memory for an error reply
    [[nodiscard]] virtual Response handle(const Request& request) = 0;

    /// For statistics: a request that the server itself has refused, and bytes of bodies, as sent.
    virtual void count_refused(int status) noexcept = 0;
    virtual void count_sent(std::uint64_t bytes) noexcept = 0;
};

}  // namespace terravox::http
