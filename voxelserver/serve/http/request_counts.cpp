#include "voxelserver/serve/http/request_counts.hpp"

#include <algorithm>

namespace terravox::http {

void RequestCounts::add(Route route, int status, double seconds) noexcept {
    OfRoute& r = m_routes[static_cast<std::size_t>(route)];
    ++r.status[static_cast<std::size_t>(std::clamp(status - kFirstStatus, 0, kStatuses - 1))];
    const auto bucket = std::lower_bound(kBucketEnds_s.begin(), kBucketEnds_s.end(), seconds) -
                        kBucketEnds_s.begin();
    ++r.bucket[static_cast<std::size_t>(bucket)];
    r.microseconds += static_cast<std::uint64_t>(std::max(seconds, 0.0) * 1e6);
}

std::map<int, std::uint64_t> RequestCounts::statuses(Route route) const {
    std::map<int, std::uint64_t> out;
    const OfRoute& r = m_routes[static_cast<std::size_t>(route)];
    for (int i = 0; i < kStatuses; ++i)
        if (const std::uint64_t n = r.status[static_cast<std::size_t>(i)]; n > 0)
            out[kFirstStatus + i] = n;
    return out;
}

RequestCounts::Times RequestCounts::times(Route route) const noexcept {
    Times out;
    const OfRoute& r = m_routes[static_cast<std::size_t>(route)];
    for (std::size_t i = 0; i < kBuckets; ++i)
        out.count += out.buckets[i] = r.bucket[i];
    out.seconds = static_cast<double>(r.microseconds) * 1e-6;
    return out;
}

std::uint64_t RequestCounts::replies() const noexcept {
    std::uint64_t out = 0;
    for (const OfRoute& r : m_routes)
        for (const auto& bucket : r.bucket)
            out += bucket;
    return out;
}

}  // namespace terravox::http
