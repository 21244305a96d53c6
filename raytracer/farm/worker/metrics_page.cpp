#include "raytracer/farm/worker/metrics_page.hpp"

#include <utility>

#include "common/util/log.hpp"
#include "common/util/text.hpp"
#include "common/util/version.hpp"

namespace terravox::farm {
namespace {

double number(std::uint64_t count) {
    return static_cast<double>(count);
}

std::size_t sum(const std::vector<WorkerSession::Status>& sessions,
                std::size_t WorkerSession::Status::* member) {
    std::size_t out = 0;
    for (const WorkerSession::Status& session : sessions)
        out += session.*member;
    return out;
}

http::Response to_reply(int status, std::string text) {
    http::Response out = http::reply(status, "text/plain; charset=utf-8", std::move(text));
    return out.add("Cache-Control", "no-store");
}

http::HostOptions to_options(const MetricsAddress& address) {
    http::HostOptions out;
    out.bind = address.host.empty() ? "0.0.0.0" : address.host;
    out.port = address.port;
    out.request_threads = 4;
    out.waiting_connections = 16;
    out.max_header_bytes = 8192;
    out.request_timeout = std::chrono::seconds(3);
    out.attempt = "open the page of metrics on";
    out.advice = "; another port may be free, 0 is any";
    return out;
}

}  // namespace

http::MetricsText write_metrics(const WorkerDaemon::Totals& m) {
    http::MetricsText text;
    const auto counter = [&](const char* name, const char* help, double value) {
        text.one(name, "counter", help, value);
    };
    const auto gauge = [&](const char* name, const char* help, double value) {
        text.one(name, "gauge", help, value);
    };
    text.family("terravox_build_info", "gauge", "The version that runs.");
    text.value(1, http::metrics_label("version", kVersion));
    gauge("terravox_worker_uptime_seconds", "Time since the start.", m.uptime_s);
    counter("terravox_worker_tiles_total", "Tiles finished.", number(m.tiles));
    counter("terravox_worker_pixels_total", "Pixels of these tiles.", number(m.pixels));
    counter("terravox_worker_rays_total", "Rays of these tiles, of all kinds.", number(m.rays));
    counter("terravox_worker_failed_total", "Tiles that could not be traced.", number(m.failed));
    counter("terravox_worker_results_bytes_total", "Bytes of results sent.",
            number(m.result_bytes));
    counter("terravox_worker_box_requests_total", "Boxes requested from coordinators.",
            number(m.box_requests));
    counter("terravox_worker_busy_seconds_total",
            "Time in which there were tiles, summed over sessions.", m.busy_s);
    counter("terravox_worker_sessions_total", "Coordinators worked for so far.",
            number(m.sessions));
    text.family("terravox_worker_refused_total", "counter",
                "Coordinators and unauthorised peers refused.");
    text.value(number(m.busy), http::metrics_label("reason", "busy"));
    text.value(number(m.unfit), http::metrics_label("reason", "unfit"));
    gauge("terravox_worker_sessions", "Coordinators worked for now.", number(m.now.size()));
    gauge("terravox_worker_threads", "Threads of a session.", m.threads);
    gauge("terravox_worker_tiles_waiting", "Tiles that are not begun.",
          number(sum(m.now, &WorkerSession::Status::waiting)));
    gauge("terravox_worker_tiles_begun", "Tiles that are begun.",
          number(sum(m.now, &WorkerSession::Status::begun)));
    gauge("terravox_worker_memory_bytes", "Resident memory.", number(m.resident_bytes));
    gauge("terravox_worker_box_bytes", "Of boxes in memory.",
          number(sum(m.now, &WorkerSession::Status::box_bytes)));
    gauge("terravox_worker_box_limit_bytes", "Most bytes of boxes that are kept.",
          number(m.memory_bytes));
    gauge("terravox_worker_draining", "1: takes no more work.", m.ending ? 1 : 0);
    return text;
}

MetricsPage::MetricsPage(const MetricsAddress& address, Snapshot snapshot)
    : m_snapshot(std::move(snapshot)),
      m_names(address.host, address.names),
      m_host(*this, to_options(address)) {}

http::Response MetricsPage::handle(const http::Request& request) {
    http::Response out = answer(request);
    out.close = true;
    return out;
}

http::Response MetricsPage::refuse(int status, const std::string& /*detail*/) {
    return to_reply(status, "allowed: a short HTTP/1.1 request, sent without delay\n");
}

http::Response MetricsPage::answer(const http::Request& request) const {
    const std::string host = request.header("Host");
    // HTTP/1.0 permits leaving it out; browsers never do.
    if (!m_names.allow(host) && !(host.empty() && request.version == "1.0"))
        return to_reply(
            421, "allowed as Host: localhost, a numeric address, or a name of metrics_names\n");
    if (http::from_another_origin(request))
        return to_reply(403, "not for web pages of another origin\n");
    if (request.path != "/metrics" && request.path != "/healthz")
        return to_reply(404, "no such page; allowed: /metrics, /healthz\n");
    if (request.method != "GET" && request.method != "HEAD")
        return to_reply(405, "allowed: GET, HEAD\n").add("Allow", "GET, HEAD");
    try {
        const WorkerDaemon::Totals totals = m_snapshot();
        if (request.path == "/metrics")
            return write_metrics(totals).take_reply();
        return totals.ending ? to_reply(503, "draining\n") : to_reply(200, "ok\n");
    } catch (const std::exception& e) {
        util::log_error("answer a request for metrics: {}", e.what());
        return to_reply(500, "the metrics cannot be collected\n");
    }
}

}  // namespace terravox::farm
