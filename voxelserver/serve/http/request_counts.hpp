#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <map>

#include "voxelserver/serve/http/routes.hpp"

namespace terravox::http {

/// Counts of the replies sent, by route and status, and their durations. Thread-safe and lock-free,
/// since every request is counted here.
class RequestCounts {
public:
    /// Upper bounds of the buckets of durations, seconds; the last bucket has none.
    static constexpr std::array kBucketEnds_s = {0.0005, 0.001, 0.005, 0.01, 0.05,
                                                 0.1,    0.5,   1.0,   5.0,  30.0};
    static constexpr std::size_t kBuckets = kBucketEnds_s.size() + 1;

    void add(Route route, int status, double seconds) noexcept;
    void add_bytes(std::uint64_t bytes) noexcept { m_bytes += bytes; }

    struct Times {
        std::array<std::uint64_t, kBuckets> buckets{};  ///< not cumulative
        std::uint64_t count = 0;
        double seconds = 0;
    };
    [[nodiscard]] std::map<int, std::uint64_t> statuses(Route route) const;
    [[nodiscard]] Times times(Route route) const noexcept;
    [[nodiscard]] std::uint64_t replies() const noexcept;
    [[nodiscard]] std::uint64_t bytes() const noexcept { return m_bytes; }  ///< of bodies, as sent

private:
    static constexpr int kFirstStatus = 100;
    static constexpr int kStatuses = 500;
    struct OfRoute {
        std::array<std::atomic<std::uint64_t>, kStatuses> status{};
        std::array<std::atomic<std::uint64_t>, kBuckets> bucket{};
        std::atomic<std::uint64_t> microseconds{0};
    };
    std::array<OfRoute, kRouteCount> m_routes;
    std::atomic<std::uint64_t> m_bytes{0};
};

}  // namespace terravox::http
