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
/// It finds the route (routes.hpp), has the request's head validated by RequestCheck and the
/// request answered by the Dispatcher, and counts the replies; exceptions become replies as well
/// (error_reply.hpp). docs/openapi.json documents the replies of each route for clients. Errors are
/// application/problem+json. No reply contains the name of a folder of this machine.
class Router {
public:
    /// @param token  "" = no token is required
    /// @param names  allowed values of the header Host
    /// @param origins of pages that may read what is shared with them
    explicit Router(Service service, std::string token = "",
                    sockets::HttpNames names = sockets::HttpNames(), SharedOrigins origins = {});

    /// @throws only when there is not enough memory for an error reply
    [[nodiscard]] Response handle(const Request& request);

    /// Checks the head of a request, without its body. Must be called before the body is read:
    /// bodies of unauthorised requests are not read.
    /// @return the reply to send; nullopt when the body (of as many bytes as the head declares)
    /// should be read and handle() be called with it
    [[nodiscard]] std::optional<Response> refusal(const Request& request);

    [[nodiscard]] RequestCounts& counts() noexcept { return m_counts; }

private:
    [[nodiscard]] Response answer(const RouteMatch& match, const Request& request);

    /// What the reply's headers say depends on the request and its route, not on the content.
    [[nodiscard]] Response fit_to(const RouteFacts& route, const Request& request,
                                  Response out) const;

    RequestCounts m_counts;
    const SharedOrigins m_origins;
    RequestCheck m_check;
    Dispatcher m_dispatcher;
};

}  // namespace terravox::http
