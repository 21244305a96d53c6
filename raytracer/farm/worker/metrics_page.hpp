#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace terravox::farm {

/// What a worker daemon tells of itself. Counts are of its whole life.
struct WorkerMetrics {
    double uptime_s = 0;
    std::uint64_t tiles = 0, pixels = 0, rays = 0;  ///< finished
    std::uint64_t failed = 0;                       ///< tiles that could not be traced
    std::uint64_t result_bytes = 0;                 ///< of results, as sent
    std::uint64_t box_requests = 0;                 ///< boxes that coordinators were asked for
    double busy_s = 0;  ///< in which there were tiles, summed over sessions
    std::uint64_t all_sessions = 0;
    std::map<std::string, std::uint64_t>
        refused;                    ///< coordinators and strangers, by a reason of one or two words
    int sessions = 0, threads = 0;  ///< now
    std::uint64_t memory_bytes = 0;  ///< of the process, in RAM
    std::uint64_t box_bytes = 0, box_limit_bytes = 0;
    std::uint64_t waiting = 0, begun = 0;  ///< tiles
    bool draining = false;                 ///< it takes no more work
};

/// In the text format of Prometheus, 0.0.4.
[[nodiscard]] std::string metrics_text(const WorkerMetrics& metrics);

/// Where the page is.
struct MetricsAddress {
    std::string host;                  ///< a number such as 127.0.0.1; empty: all networks
    std::uint16_t port = 0;            ///< 0: any free one
    std::vector<std::string> names{};  ///< that it may be asked by, beside those of net::HttpNames
};

/// A small HTTP page for machines that watch a worker (CivetWeb): GET and HEAD of /metrics, and of
/// /healthz (200 "ok", 503 while it drains); 404 for anything else, 405 for other methods, 421 for
/// a host name that is none of its own, 403 for web pages of other origins. No body of a request is
/// read, and each reply ends its connection. Whoever reaches the address may read it: it is meant
/// for loopback or a network of one's own. A connection gets three seconds for its request, and
/// half a second when others wait (net::SlowClients); four of them are answered at a time, 16 more
/// wait.
class MetricsPage {
public:
    /// Called on threads of the page; what it throws is told by 500.
    using Snapshot = std::function<WorkerMetrics()>;
    /// Answers from here on.
    /// @throws UsageError for a host that is no number, or a name that is none; Error when it
    /// cannot listen there
    MetricsPage(const MetricsAddress& address, Snapshot snapshot);
    ~MetricsPage();  ///< no call of the snapshot after it; takes up to two seconds
    MetricsPage(const MetricsPage&) = delete;
    MetricsPage& operator=(const MetricsPage&) = delete;

    [[nodiscard]] std::uint16_t port() const noexcept;

private:
    class Impl;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace terravox::farm
