#pragma once

#include <chrono>
#include <string>

#include "voxelserver/http/service.hpp"

namespace terravox::http {

/// Answers requests about one world: a function of the request, without sockets. Thread-safe.
///
/// The routes are in routes.hpp, and what each answers in the *_routes.hpp files; docs/openapi.json says it for clients. HEAD works
/// wherever GET does; other methods: 405. A body where none belongs: 413, and the connection is to be closed. With a token, routes that
/// are not open want it: 401. What handling throws becomes 500, too many at work 503. Errors are application/problem+json.
class Router {
public:
    /// @param token  "" = anybody may ask
    explicit Router(Service service, std::string token = "");

    /// @throws only when there is no memory even for an error
    [[nodiscard]] Response handle(const Request& request);

    /// Most bytes of a body that a request of this method and path may bring, to be read before handle(); 0: none.
    [[nodiscard]] static std::size_t most_body_bytes(std::string_view method, std::string_view path) noexcept;

    [[nodiscard]] RequestCounts& counts() noexcept { return m_counts; }
    [[nodiscard]] Service& service() noexcept { return m_service; }

private:
    [[nodiscard]] Response answer(const RouteFacts& route, const Asked& asked);
    [[nodiscard]] Response checked(const RouteFacts& route, const Asked& asked);
    [[nodiscard]] Response dispatch(Route route, const Asked& asked);
    [[nodiscard]] Response world(const Request& request) const;
    [[nodiscard]] bool may_ask(const Request& request) const;

    Service m_service;
    const std::string m_token;
    RequestCounts m_counts;
    const std::chrono::steady_clock::time_point m_start = std::chrono::steady_clock::now();
    const std::string m_world_json, m_world_etag;
};

}  // namespace terravox::http
