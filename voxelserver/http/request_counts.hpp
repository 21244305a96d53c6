#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <mutex>

namespace terravox::http {

/// What a request was for. kUnknown: no such path; kRefused: not even a request (malformed, too large, too late).
enum class Route { kIndex, kHealth, kWorld, kBoxes, kColumns, kStats, kUnknown, kRefused };
inline constexpr std::size_t kRouteCount = 8;
[[nodiscard]] const char* route_name(Route route) noexcept;

/// Replies sent, by route and status. Thread-safe.
class RequestCounts {
public:
    using Statuses = std::map<int, std::uint64_t>;
    void add(Route route, int status);
    [[nodiscard]] std::array<Statuses, kRouteCount> counts() const;

private:
    mutable std::mutex m_mutex;
    std::array<Statuses, kRouteCount> m_counts;
};

}  // namespace terravox::http
