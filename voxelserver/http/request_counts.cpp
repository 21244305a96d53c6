#include "voxelserver/http/request_counts.hpp"

namespace terravox::http {

const char* route_name(Route route) noexcept {
    static constexpr std::array<const char*, kRouteCount> kNames = {"/",           "/healthz",  "/v2/world", "/v2/boxes",
                                                                     "/v2/columns", "/v2/stats", "unknown",   "refused"};
    return kNames[static_cast<std::size_t>(route)];
}

void RequestCounts::add(Route route, int status) {
    const std::lock_guard lock(m_mutex);
    ++m_counts[static_cast<std::size_t>(route)][status];
}

std::array<RequestCounts::Statuses, kRouteCount> RequestCounts::counts() const {
    const std::lock_guard lock(m_mutex);
    return m_counts;
}

}  // namespace terravox::http
