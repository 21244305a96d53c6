#pragma once

#include <optional>
#include <string>

#include "voxelserver/http/dispatcher.hpp"
#include "voxelserver/http/request_check.hpp"
#include "voxelserver/http/service.hpp"
#include "voxelserver/sockets/http_host.hpp"

namespace terravox::http {

/// Answers requests about one world: a function of the request, without sockets. Thread-safe.
///
/// It finds the route (routes.hpp), lets RequestCheck refuse what its head makes wrong and the
/// Dispatcher answer the rest, and counts the replies; what is thrown meanwhile becomes a reply,
/// too (error_reply.hpp). docs/openapi.json says for clients what each route answers. Errors are
/// application/problem+json. No reply names a folder of this machine.
class Router {
public:
    /// @param token  "" = anybody may ask
    /// @param names  that requests may name in their header Host
    explicit Router(Service service, std::string token = "",
                    sockets::HttpNames names = sockets::HttpNames());

    /// @throws only when there is no memory even for an error
    [[nodiscard]] Response handle(const Request& request);

    /// What handle() would refuse for its head alone. To be asked before a body is read: a
    /// stranger's is not worth reading.
    /// @return nothing where the body is to be read, of as many bytes as the head says, and
    /// handle() to be called with it
    [[nodiscard]] std::optional<Response> refusal(const Request& request);

    [[nodiscard]] RequestCounts& counts() noexcept { return m_counts; }

private:
    [[nodiscard]] Response answer(const RouteMatch& match, const Request& request);

    RequestCounts m_counts;
    const RequestCheck m_check;
    Dispatcher m_dispatcher;
};

}  // namespace terravox::http
