#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "voxelserver/http/service.hpp"
#include "voxelserver/sockets/http_host.hpp"

namespace terravox::http {

/// Answers requests about one world: a function of the request, without sockets. Thread-safe.
///
/// The routes are in routes.hpp, and what each answers in the *_routes.hpp files; docs/openapi.json
/// says it for clients. HEAD works wherever GET does; other methods: 405. A body where none
/// belongs: 413, and the connection is to be closed. With a token, routes that are not open want
/// it: 401. A host name that is none of the server's: 421; a page of another origin: 403. What
/// handling throws becomes 500, too many at work 503, a far world whose server does not answer 502.
/// A request that names another edition of the world: 412. Errors are application/problem+json. No
/// reply names a folder of this machine.
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
    [[nodiscard]] Service& service() noexcept { return m_service; }

private:
    [[nodiscard]] Response answer(const RouteFacts& route, const Request& request,
                                  const PathParts& parts);
    [[nodiscard]] std::optional<Response> refuse_head(const RouteFacts& route,
                                                      const Request& request) const;
    [[nodiscard]] Response health(const RouteRequest& asked) const;
    [[nodiscard]] Response dispatch(Route route, const RouteRequest& asked);
    [[nodiscard]] Response world(const Request& request) const;
    [[nodiscard]] bool has_token(const Request& request) const;

    Service m_service;
    const std::string m_token;
    const sockets::HttpNames m_names;
    RequestCounts m_counts;
    const std::chrono::steady_clock::time_point m_start = std::chrono::steady_clock::now();
    const std::string m_world_json, m_world_etag;
};

}  // namespace terravox::http
