#pragma once

#include <chrono>
#include <optional>

#include "voxelserver/serve/http/service.hpp"
#include "voxelserver/serve/http/world_route.hpp"

namespace terravox::http {

/// Calls the handler of a route; the replies are documented in the *_routes.hpp files. Thread-safe.
///
/// The head of a request has been checked before (request_check.hpp), except for the edition that
/// it names: when it differs from that of the world, the reply is 412 and no handler is called.
class Dispatcher {
public:
    /// @param counts for /v2/stats and /metrics; must outlive this
    Dispatcher(Service service, const RequestCounts& counts);

    /// @throws whatever the handler throws; the router converts it to a reply (error_reply.hpp)
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

}  // namespace terravox::http
