#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "raytracer/farm/worker/worker_daemon.hpp"
#include "voxelserver/serve/host/host.hpp"
#include "voxelserver/serve/host/host_names.hpp"
#include "voxelserver/serve/host/metrics_text.hpp"

namespace terravox::farm {

/// A daemon's totals for monitoring systems.
[[nodiscard]] http::MetricsText write_metrics(const WorkerDaemon::Totals& totals);

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
    using Snapshot = std::function<WorkerDaemon::Totals()>;
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
