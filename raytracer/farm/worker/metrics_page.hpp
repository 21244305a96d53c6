#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "voxelserver/serve/host/host.hpp"
#include "voxelserver/serve/host/host_names.hpp"

namespace terravox::farm {

/// Metrics of a worker daemon. Counts cover its whole life.
struct WorkerMetrics {
    double uptime_s = 0;
    std::uint64_t tiles = 0, pixels = 0, rays = 0;  ///< finished
    std::uint64_t failed = 0;                       ///< tiles that could not be traced
    std::uint64_t result_bytes = 0;                 ///< of results, as sent
    std::uint64_t box_requests = 0;                 ///< boxes requested from coordinators
    double busy_s = 0;  ///< time during which there were tiles, summed over sessions
    std::uint64_t all_sessions = 0;
    /// Refused coordinators and unauthorised peers, by a reason of one or two words.
    std::map<std::string, std::uint64_t> refused;
    int sessions = 0, threads = 0;   ///< now
    std::uint64_t memory_bytes = 0;  ///< of the process, in RAM
    std::uint64_t box_bytes = 0;
    std::uint64_t box_limit_bytes = 0;
    std::uint64_t waiting = 0, begun = 0;  ///< tiles
    bool draining = false;                 ///< it accepts no more work
};

/// Formats the metrics as Prometheus text, version 0.0.4.
[[nodiscard]] std::string metrics_text(const WorkerMetrics& metrics);

/// Address of the page.
struct MetricsAddress {
    std::string host;        ///< a numeric address such as 127.0.0.1; empty: all networks
    std::uint16_t port = 0;  ///< 0: any free one
    /// Accepted host names, in addition to those of http::HostNames.
    std::vector<std::string> names{};
};

/// A small HTTP page for monitoring systems (CivetWeb): GET and HEAD of /metrics, and of /healthz
/// (200 "ok", 503 while it drains); 404 for anything else, 405 for other methods, 421 for a host
/// name that is none of its own, 403 for web pages of other origins. Request bodies are not read,
/// and each reply ends its connection. Any client that reaches the address may read it: it is meant
/// for loopback or a private network. A connection gets three seconds for its request, and half a
/// second when others wait (http::SlowClients); four of them are answered at a time, 16 more
/// wait.
class MetricsPage final : public http::RequestHandler {
public:
    /// Called on threads of the page; an exception is answered with status 500.
    using Snapshot = std::function<WorkerMetrics()>;
    /// Begins to answer requests, until the destruction, which takes up to two seconds.
    /// @throws UsageError for a host that is not numeric, or an invalid name; Error when it cannot
    /// listen there
    MetricsPage(const MetricsAddress& address, Snapshot snapshot);

    [[nodiscard]] std::uint16_t port() const noexcept {
        return static_cast<std::uint16_t>(m_host.port());
    }

    // As the host asks it. No body is read: each reply is known without it.
    [[nodiscard]] std::optional<http::Response> refusal(const http::Request& request) override {
        return handle(request);
    }
    [[nodiscard]] http::Response handle(const http::Request& request) override;
    [[nodiscard]] http::Response refuse(int status, const std::string& detail) override;

private:
    [[nodiscard]] http::Response answer(const http::Request& request) const;

    const Snapshot m_snapshot;
    const http::HostNames m_names;
    http::Host m_host;  ///< the last: its threads use the others
};

}  // namespace terravox::farm
