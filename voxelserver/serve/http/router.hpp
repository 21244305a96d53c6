#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "voxelserver/serve/http/request_check.hpp"
#include "voxelserver/serve/http/route_answers.hpp"
#include "voxelserver/serve/http/server.hpp"
#include "voxelserver/serve/http/service.hpp"
#include "voxelserver/serve/sockets/http_host.hpp"

namespace terravox::http {

/// Calls the handler of a route; the replies are documented in the *_routes.hpp files. Thread-safe.
///
/// The head of a request has been checked before (request_check.hpp), except for the edition that
/// it names: when it differs from that of the world, the reply is 412 and no handler is called.
class Dispatcher {
public:
    /// @param counts for /v2/stats and /metrics; must outlive this
    Dispatcher(Service service, const RequestCounts& counts);

    /// @throws whatever the handler throws; the router converts it to a reply (service.hpp)
    [[nodiscard]] Response run(Route route, const RouteRequest& call);

private:
    [[nodiscard]] std::optional<Response> refuse_edition(const Request& request) const;
    [[nodiscard]] Response call_handler(Route route, const RouteRequest& call);
    [[nodiscard]] double uptime_s() const noexcept;

    Service m_service;
    const RequestCounts& m_counts;
    const WorldRoute m_world;
    const std::chrono::steady_clock::time_point m_start = std::chrono::steady_clock::now();
};

/// Answers requests about one world: a function of the request, without sockets. Thread-safe.
///
/// It finds the route (routes.hpp), has the request's head validated by RequestCheck and the
/// request answered by the Dispatcher, and counts the replies; exceptions become replies as well
/// (service.hpp). docs/openapi.json documents the replies of each route for clients. Errors are
/// application/problem+json. No reply contains the name of a folder of this machine.
class Router : public RequestHandler {
public:
    /// @param token  "" = no token is required
    /// @param names  allowed values of the header Host
    /// @param origins of pages that may read what is shared with them
    explicit Router(Service service, std::string token = "",
                    sockets::HttpNames names = sockets::HttpNames(), SharedOrigins origins = {});

    [[nodiscard]] std::optional<Response> refusal(const Request& request) override;
    [[nodiscard]] Response handle(const Request& request) override;
    void count_refused(int status) noexcept override { m_counts.add(Route::kRefused, status, 0); }
    void count_sent(std::uint64_t bytes) noexcept override { m_counts.add_bytes(bytes); }

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
