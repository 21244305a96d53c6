#include "raytracer/farm/worker/metrics_page.hpp"

#include <arpa/inet.h>
#include <civetweb.h>
#include <strings.h>

#include <array>
#include <mutex>
#include <string_view>

#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/util/text.hpp"
#include "common/util/version.hpp"
#include "voxelserver/serve/sockets/http_host.hpp"
#include "voxelserver/serve/sockets/slow_clients.hpp"

namespace terravox::farm {
namespace {

/// Ref: Prometheus, "Exposition formats", text format 0.0.4.
class Text {
public:
    void family(const char* name, const char* type, const char* help) {
        m_name = name;
        m_out.append("# HELP ")
            .append(name)
            .append(" ")
            .append(help)
            .append("\n# TYPE ")
            .append(name)
            .append(" ")
            .append(type)
            .append("\n");
    }
    void value(double number, const std::string& label = {}) {
        m_out += m_name + label + " " + util::number_text(number, 17) + "\n";
    }
    void counter(const char* name, const char* help, double number) {
        family(name, "counter", help);
        value(number);
    }
    void gauge(const char* name, const char* help, double number) {
        family(name, "gauge", help);
        value(number);
    }
    [[nodiscard]] std::string take() { return std::move(m_out); }

private:
    std::string m_name;
    std::string m_out;
};

std::string label(const char* name, std::string_view value) {
    std::string out = std::string("{") + name + "=\"";
    for (const char c : value) {
        if (c == '\\' || c == '"')
            out += '\\';
        out += c == '\n' ? ' ' : c;
    }
    return out + "\"}";
}

/// @return the header's value; "" where there is none, or more than one
std::string_view header(const mg_request_info& info, const char* name) {
    std::string_view found;
    for (int i = 0; i < info.num_headers; ++i) {
        if (strcasecmp(info.http_headers[i].name, name) != 0)
            continue;
        if (found.data() != nullptr)
            return {};
        found = info.http_headers[i].value;
    }
    return found;
}

double number(std::uint64_t count) {
    return static_cast<double>(count);
}

struct Reply {
    int status = 200;
    const char* phrase = "OK";
    std::string body = "ok\n";
    const char* type = "text/plain; charset=utf-8";
    const char* more = "";
};

void send(mg_connection* connection, const Reply& reply, bool head_only) {
    std::string out = "HTTP/1.1 " + std::to_string(reply.status) + " " + reply.phrase +
                      "\r\nContent-Type: " + reply.type +
                      "\r\nContent-Length: " + std::to_string(reply.body.size()) +
                      "\r\nCache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n"
                      "Cross-Origin-Resource-Policy: same-origin\r\n" +
                      reply.more + "Connection: close\r\n\r\n";
    if (!head_only)
        out += reply.body;
    mg_write(connection, out.data(), out.size());
    // Otherwise CivetWeb would read, and wait for, a body of any length that the client has
    // announced.
    mg_disable_connection_keep_alive(connection);
}

std::string listening_port(const std::string& host, std::uint16_t port) {
    std::array<unsigned char, sizeof(in6_addr)> ignored{};
    if (host.empty())
        return std::to_string(port);
    if (inet_pton(AF_INET, host.c_str(), ignored.data()) == 1)
        return host + ":" + std::to_string(port);
    if (inet_pton(AF_INET6, host.c_str(), ignored.data()) != 1)
        throw util::UsageError(
            "open the page of metrics on '" + host +
            "': not an address; allowed: numbers, such as 127.0.0.1 (this machine) or "
            "0.0.0.0 (all networks)");
    if (mg_check_feature(MG_FEATURES_IPV6) == 0)
        throw util::UsageError("open the page of metrics on " + host +
                               ": this build of CivetWeb has no IPv6; allowed: IPv4");
    return "[" + host + "]:" + std::to_string(port);
}

}  // namespace

std::string metrics_text(const WorkerMetrics& m) {
    Text text;
    text.family("terravox_build_info", "gauge", "The version that runs.");
    text.value(1, label("version", kVersion));
    text.gauge("terravox_worker_uptime_seconds", "Time since the start.", m.uptime_s);
    text.counter("terravox_worker_tiles_total", "Tiles finished.", number(m.tiles));
    text.counter("terravox_worker_pixels_total", "Pixels of these tiles.", number(m.pixels));
    text.counter("terravox_worker_rays_total", "Rays of these tiles, of all kinds.",
                 number(m.rays));
    text.counter("terravox_worker_failed_total", "Tiles that could not be traced.",
                 number(m.failed));
    text.counter("terravox_worker_results_bytes_total", "Bytes of results sent.",
                 number(m.result_bytes));
    text.counter("terravox_worker_box_requests_total", "Boxes requested from coordinators.",
                 number(m.box_requests));
    text.counter("terravox_worker_busy_seconds_total",
                 "Time in which there were tiles, summed over sessions.", m.busy_s);
    text.counter("terravox_worker_sessions_total", "Coordinators worked for so far.",
                 number(m.all_sessions));
    text.family("terravox_worker_refused_total", "counter",
                "Coordinators and unauthorised peers refused.");
    for (const auto& [reason, count] : m.refused)
        text.value(number(count), label("reason", reason));
    text.gauge("terravox_worker_sessions", "Coordinators worked for now.", m.sessions);
    text.gauge("terravox_worker_threads", "Threads of a session.", m.threads);
    text.gauge("terravox_worker_tiles_waiting", "Tiles that are not begun.", number(m.waiting));
    text.gauge("terravox_worker_tiles_begun", "Tiles that are begun.", number(m.begun));
    text.gauge("terravox_worker_memory_bytes", "Resident memory.", number(m.memory_bytes));
    text.gauge("terravox_worker_box_bytes", "Of boxes in memory.", number(m.box_bytes));
    text.gauge("terravox_worker_box_limit_bytes", "Most bytes of boxes that are kept.",
               number(m.box_limit_bytes));
    text.gauge("terravox_worker_draining", "1: takes no more work.", m.draining ? 1 : 0);
    return text.take();
}

/// CivetWeb calls back on its own threads, through C: no exception may leave a callback. A lock
/// guards the message of a failed start; nothing else changes once it has started.
class MetricsPage::Impl {
public:
    Impl(const MetricsAddress& address, Snapshot snapshot)
        : m_snapshot(std::move(snapshot)),
          m_names(address.host, address.names),
          m_slow_clients({.connections = kThreads - 1}) {
        static std::once_flag once;
        std::call_once(once, [] { mg_init_library(MG_FEATURES_DEFAULT); });
        mg_callbacks callbacks{};
        callbacks.begin_request = on_request;
        callbacks.http_error = on_refusal;
        callbacks.log_message = on_log;
        const std::string listen = listening_port(address.host, address.port);
        const std::string threads = std::to_string(kThreads);
        // Names and values alternate, as CivetWeb expects them.
        std::array<const char*, 15> settings = {"listening_ports",
                                                listen.c_str(),
                                                "num_threads",
                                                threads.c_str(),
                                                "connection_queue",
                                                "16",
                                                "max_request_size",
                                                "8192",
                                                "request_timeout_ms",
                                                "3000",
                                                "decode_url",
                                                "no",
                                                "enable_auth_domain_check",
                                                "no",
                                                nullptr};
        m_context = mg_start(&callbacks, this, settings.data());
        if (m_context == nullptr) {
            const std::lock_guard lock(m_mutex);
            throw util::Error("open the page of metrics on " + listen + ": " +
                              (m_message.empty() ? "CivetWeb could not start" : m_message) +
                              "; another port may be free, 0 is any");
        }
        mg_server_port opened{};
        if (mg_get_server_ports(m_context, 1, &opened) == 1)
            m_port = static_cast<std::uint16_t>(opened.port);
        try {
            m_slow_clients.watch(m_port);
        } catch (...) {
            mg_stop(m_context);  // its threads use this object
            throw;
        }
    }
    ~Impl() {
        if (m_context != nullptr)
            mg_stop(m_context);
    }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;
    [[nodiscard]] std::uint16_t port() const noexcept { return m_port; }

private:
    static Impl& self(const mg_connection* connection) noexcept {
        return *static_cast<Impl*>(mg_get_user_data(mg_get_context(connection)));
    }

    // @return the status that was sent: CivetWeb then does nothing more about the request
    static int on_request(mg_connection* connection) noexcept {
        try {
            const mg_request_info& info = *mg_get_request_info(connection);
            Impl& me = self(connection);
            const sockets::SlowClients::Answering answering(me.m_slow_clients, info.remote_addr,
                                                            info.remote_port);
            const Reply reply = me.answer(info);
            send(connection, reply, std::string_view(info.request_method) == "HEAD");
            return reply.status;
        } catch (const std::exception& e) {
            util::log_error("answer a request for metrics: {}", e.what());
            mg_disable_connection_keep_alive(connection);
            return 500;
        }
    }
    [[nodiscard]] Reply answer(const mg_request_info& info) const {
        const std::string_view method = info.request_method;
        const std::string_view path = info.local_uri_raw != nullptr ? info.local_uri_raw : "";
        const std::string_view host = header(info, "Host");
        // HTTP/1.0 permits leaving it out; browsers never do.
        if (!m_names.allow(host) && !(host.empty() && std::string_view(info.http_version) == "1.0"))
            return {421, "Misdirected Request",
                    "allowed as Host: localhost, a numeric address, or a name of metrics_names\n"};
        if (sockets::from_another_origin(
                {host, header(info, "Origin"), header(info, "Sec-Fetch-Site"),
                 header(info, "Sec-Fetch-Mode"), header(info, "Sec-Fetch-Dest"), method}))
            return {403, "Forbidden", "not for web pages of another origin\n"};
        if (path != "/metrics" && path != "/healthz")
            return {404, "Not Found", "no such page; allowed: /metrics, /healthz\n"};
        if (method != "GET" && method != "HEAD")
            return {405, "Method Not Allowed", "allowed: GET, HEAD\n", "text/plain; charset=utf-8",
                    "Allow: GET, HEAD\r\n"};
        try {
            const WorkerMetrics metrics = m_snapshot();
            if (path == "/metrics")
                return {200, "OK", metrics_text(metrics),
                        "text/plain; version=0.0.4; charset=utf-8"};
            if (metrics.draining)
                return {503, "Service Unavailable", "draining\n"};
            return {};
        } catch (const std::exception& e) {
            util::log_error("answer a request for metrics: {}", e.what());
            return {500, "Internal Server Error", "the metrics cannot be collected\n"};
        }
    }
    static int on_refusal(mg_connection* connection, int status, const char* /*message*/) noexcept {
        try {
            send(connection,
                 {status, "Refused", "allowed: a short HTTP/1.1 request, sent without delay\n"},
                 false);
        } catch (const std::exception& e) {
            util::log_error("refuse a request for metrics: {}", e.what());
        }
        return 0;
    }
    static int on_log(const mg_connection* connection, const char* message) noexcept {
        try {
            util::log_debug("CivetWeb: {}", message);
            Impl& me = self(connection);
            const std::lock_guard lock(me.m_mutex);
            me.m_message = message;
        } catch (const std::exception&) {
        }
        return 1;
    }

    static constexpr int kThreads = 4;

    const Snapshot m_snapshot;
    const sockets::HttpNames m_names;
    sockets::SlowClients m_slow_clients;
    mg_context* m_context = nullptr;
    std::mutex m_mutex;
    std::string m_message;  ///< CivetWeb's last
    std::uint16_t m_port = 0;
};

MetricsPage::MetricsPage(const MetricsAddress& address, Snapshot snapshot)
    : m_impl(std::make_unique<Impl>(address, std::move(snapshot))) {}
MetricsPage::~MetricsPage() = default;
std::uint16_t MetricsPage::port() const noexcept {
    return m_impl->port();
}

}  // namespace terravox::farm
