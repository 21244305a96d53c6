#include "voxelserver/http/server.hpp"

#include <arpa/inet.h>
#include <civetweb.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <ctime>
#include <mutex>
#include <vector>

#include "common/util/error.hpp"

namespace terravox::http {
namespace {

constexpr const char* kMostHeaderBytes = "16384";
constexpr const char* kConnectionQueue = "128";
constexpr std::string_view kLastResortBody = "{\"type\":\"about:blank\",\"title\":\"Internal Server Error\",\"status\":500}\n";
constexpr std::string_view kLastResortHead =
    "HTTP/1.1 500 Internal Server Error\r\nContent-Type: application/problem+json\r\nContent-Length: 68\r\nConnection: close\r\n\r\n";
static_assert(kLastResortBody.size() == 68);

bool is_ipv6(const std::string& address) { return address.find(':') != std::string::npos; }

std::string endpoint(const std::string& address, int port) {
    return (is_ipv6(address) ? "[" + address + "]" : address) + ":" + std::to_string(port);
}

[[noreturn]] void fail_to_listen(const ServerOptions& o, const std::string& why) {
    throw Error("listen on " + endpoint(o.bind, o.port) + ": " + why + "; --port chooses another port, 0 any free one");
}

struct Address {
    sockaddr_storage storage{};
    socklen_t length = 0;
};

Address address_of(const ServerOptions& o) {
    if (o.port < 0 || o.port > 65535) throw UsageError("listen: port " + std::to_string(o.port) + "; allowed: 0 to 65535");
    Address out;
    if (is_ipv6(o.bind)) {
        auto* a = reinterpret_cast<sockaddr_in6*>(&out.storage);
        a->sin6_family = AF_INET6;
        a->sin6_port = htons(static_cast<std::uint16_t>(o.port));
        out.length = sizeof *a;
        if (inet_pton(AF_INET6, o.bind.c_str(), &a->sin6_addr) == 1) {
            if (mg_check_feature(MG_FEATURES_IPV6) == 0) throw UsageError("listen on " + o.bind + ": this build of CivetWeb has no IPv6; allowed: IPv4");
            return out;
        }
    } else {
        auto* a = reinterpret_cast<sockaddr_in*>(&out.storage);
        a->sin_family = AF_INET;
        a->sin_port = htons(static_cast<std::uint16_t>(o.port));
        out.length = sizeof *a;
        if (inet_pton(AF_INET, o.bind.c_str(), &a->sin_addr) == 1) return out;
    }
    throw UsageError("listen on '" + o.bind + "': not an address; allowed: numbers, such as 127.0.0.1 (this machine) or 0.0.0.0 (all networks)");
}

std::string http_date() {
    const std::time_t now = std::time(nullptr);
    std::tm utc{};
    gmtime_r(&now, &utc);
    std::array<char, 40> text{};
    const std::size_t length = std::strftime(text.data(), text.size(), "%a, %d %b %Y %H:%M:%S GMT", &utc);
    return {text.data(), length};
}

std::string head_of(const Response& r, bool keep_alive) {
    std::string out = "HTTP/1.1 " + std::to_string(r.status) + " " + std::string(reason_phrase(r.status)) + "\r\nDate: " + http_date() + "\r\n";
    for (const Header& h : r.headers) out += h.name + ": " + h.value + "\r\n";
    if (r.status != 204 && r.status != 304) out += "Content-Length: " + std::to_string(r.content_length()) + "\r\n";
    out += "X-Content-Type-Options: nosniff\r\n";
    out += keep_alive ? "Connection: keep-alive\r\n\r\n" : "Connection: close\r\n\r\n";
    return out;
}

bool has_token(const std::string& list, std::string_view token) {
    std::size_t begin = 0;
    while (begin <= list.size()) {
        const std::size_t end = std::min(list.find(',', begin), list.size());
        std::string_view word(list.data() + begin, end - begin);
        while (!word.empty() && (word.front() == ' ' || word.front() == '\t')) word.remove_prefix(1);
        while (!word.empty() && (word.back() == ' ' || word.back() == '\t')) word.remove_suffix(1);
        if (same_word(word, token)) return true;
        begin = end + 1;
    }
    return false;
}

// What CivetWeb decides from the same header; told to the client before.
bool wants_keep_alive(const Request& request, const char* http_version) {
    const std::string connection = request.header("Connection");
    if (!connection.empty()) return has_token(connection, "keep-alive");
    return http_version != nullptr && std::strcmp(http_version, "1.1") == 0;
}

bool write_all(mg_connection* connection, const char* data, std::size_t bytes) noexcept {
    return bytes == 0 || mg_write(connection, data, bytes) == static_cast<int>(bytes);
}

void send(mg_connection* connection, const Response& r, bool keep_alive) {
    const std::string head = head_of(r, keep_alive);
    bool sent = write_all(connection, head.data(), head.size());
    if (sent && r.body && !r.head_only) sent = write_all(connection, r.body->data(), r.body->size());
    // Closing also keeps CivetWeb from reading (and waiting for) a body of any length that the client announced.
    if (!sent || !keep_alive) mg_disable_connection_keep_alive(connection);
}

Request request_of(const mg_request_info& info) {
    Request out;
    out.method = info.request_method;
    out.path = info.local_uri_raw;  // not decoded: no address of the interface needs an escape
    for (int i = 0; i < info.num_headers; ++i) out.headers.push_back({info.http_headers[i].name, info.http_headers[i].value});
    return out;
}

// What CivetWeb itself refuses. 1.15 calls a header that is too long, too slow or cut off a malformed message (400); where
// a version has a 413 for the first, that is about the header, which is 431's meaning.
Response refusal(int status, const char* message) {
    std::string detail = std::string("read the request: ") + (message != nullptr ? message : "refused");
    if (status == 400 || status == 413) detail += std::string("; allowed: HTTP/1.1, a header of up to ") + kMostHeaderBytes + " bytes, sent without delay";
    return problem(status == 413 ? 431 : status, detail);
}

}  // namespace

void check_can_listen(const ServerOptions& options) {
    const Address address = address_of(options);
    const int probe = socket(address.storage.ss_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (probe < 0) fail_to_listen(options, std::strerror(errno));
    const int on = 1;
    setsockopt(probe, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);  // as CivetWeb does
    const bool bound = bind(probe, reinterpret_cast<const sockaddr*>(&address.storage), address.length) == 0;
    const int error = errno;
    close(probe);
    if (!bound) fail_to_listen(options, std::strerror(error));
}

/// CivetWeb calls back on its own threads, through C: nothing may be thrown there.
///
/// One lock guards the count of running requests, the flags and the message; it is not held while a request is answered.
class Server::Impl {
public:
    Impl(Router& router, const ServerOptions& options) : m_router(router), m_options(options) {
        check_can_listen(options);
        static std::once_flag once;
        std::call_once(once, [] { mg_init_library(MG_FEATURES_DEFAULT); });
        mg_callbacks callbacks{};
        callbacks.begin_request = on_request;
        callbacks.http_error = on_refusal;
        callbacks.log_message = on_log;
        callbacks.init_connection = on_connection;
        callbacks.connection_close = on_connection_close;
        const std::string listen = endpoint(options.bind, options.port), threads = std::to_string(std::max(options.request_threads, 1));
        const std::string request_ms = std::to_string(options.request_timeout.count()), keep_ms = std::to_string(options.keep_alive_timeout.count());
        // No document_root: CivetWeb serves no files. No check of Host against a domain: there is only one world here.
        const std::array<const char*, 21> settings = {"listening_ports",    listen.c_str(),     "num_threads",              threads.c_str(),
                                                      "connection_queue",   kConnectionQueue,   "max_request_size",         kMostHeaderBytes,
                                                      "request_timeout_ms", request_ms.c_str(), "keep_alive_timeout_ms",    keep_ms.c_str(),
                                                      "enable_keep_alive",  "yes",              "tcp_nodelay",              "1",
                                                      "decode_url",         "no",               "enable_auth_domain_check", "no",
                                                      nullptr};
        m_context = mg_start(&callbacks, this, const_cast<const char**>(settings.data()));
        if (m_context == nullptr) fail_to_listen(options, m_last_message.empty() ? "CivetWeb could not start" : m_last_message);
        {
            const std::lock_guard lock(m_mutex);
            m_started = true;
        }
        mg_server_port port{};
        if (mg_get_server_ports(m_context, 1, &port) == 1) m_port = port.port;
    }

    ~Impl() { stop(); }

    [[nodiscard]] int port() const noexcept { return m_port; }
    [[nodiscard]] std::string url() const { return "http://" + endpoint(m_options.bind, m_port); }

    void stop() noexcept {
        if (m_context == nullptr) return;
        {
            // mg_stop cuts replies short: let them finish first.
            std::unique_lock lock(m_mutex);
            m_draining = true;
            if (!m_finished.wait_for(lock, m_options.drain_timeout, [&] { return m_running == 0; }))
                spdlog::warn("stopping with {} requests unfinished after {} s", m_running, m_options.drain_timeout.count() / 1000.0);
        }
        mg_stop(m_context);
        m_context = nullptr;
    }

private:
    static Impl& self(const mg_connection* connection) noexcept { return *static_cast<Impl*>(mg_get_user_data(mg_get_context(connection))); }

    static int on_request(mg_connection* connection) noexcept { return self(connection).handle(connection); }

    static int on_refusal(mg_connection* connection, int status, const char* message) noexcept {
        try {
            const Response out = refusal(status, message);
            self(connection).m_router.counts().add(Route::kRefused, out.status);
            spdlog::debug("refused: {} {}", out.status, message != nullptr ? message : "");
            send(connection, out, false);
        } catch (...) {
            send_last_resort(connection);
        }
        return 0;
    }

    static int on_log(const mg_connection* connection, const char* message) noexcept {
        try {
            spdlog::debug("CivetWeb: {}", message);
            Impl& me = self(connection);
            const std::lock_guard lock(me.m_mutex);
            if (!me.m_started) me.m_last_message = message;
        } catch (...) {
        }
        return 1;
    }

    static int on_connection(const mg_connection* connection, void** /*data*/) noexcept {
        ++self(connection).m_connections;
        return 0;
    }

    static void on_connection_close(const mg_connection* connection) noexcept { --self(connection).m_connections; }

    static void send_last_resort(mg_connection* connection) noexcept {
        if (write_all(connection, kLastResortHead.data(), kLastResortHead.size())) write_all(connection, kLastResortBody.data(), kLastResortBody.size());
        mg_disable_connection_keep_alive(connection);
    }

    // @return the status that was sent: CivetWeb then does nothing more about the request
    int handle(mg_connection* connection) noexcept {
        const Running running(*this);
        try {
            const mg_request_info& info = *mg_get_request_info(connection);
            const Request request = request_of(info);
            const auto start = std::chrono::steady_clock::now();
            const Response out = running.draining() ? shutting_down() : info.num_headers >= MG_MAX_HEADERS ? too_many_headers() : m_router.handle(request);
            const bool others_wait = m_connections >= m_options.request_threads;
            const bool keep_alive = !out.close && !others_wait && wants_keep_alive(request, info.http_version);
            send(connection, out, keep_alive);
            spdlog::debug("{} {} {} {:.1f} ms", request.method, request.path, out.status,
                          std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
            return out.status;
        } catch (const std::exception& e) {
            log_failure(e.what());
        } catch (...) {
            log_failure("unknown error");
        }
        send_last_resort(connection);
        return 500;
    }

    static void log_failure(const char* what) noexcept {
        try {
            spdlog::error("answer a request: {}", what);
        } catch (...) {
        }
    }

    Response shutting_down() {
        Response out = problem(503, "the server is shutting down");
        out.headers.push_back({"Retry-After", "5"});
        out.close = true;
        m_router.counts().add(Route::kRefused, out.status);
        return out;
    }

    // CivetWeb leaves out further headers: one of them could announce a body, to be taken for the next request.
    Response too_many_headers() {
        Response out = problem(431, "read the request: " + std::to_string(MG_MAX_HEADERS) + " or more headers");
        out.close = true;
        m_router.counts().add(Route::kRefused, out.status);
        return out;
    }

    /// A request that stop() waits for, unless it came after stop() was called.
    class Running {
    public:
        explicit Running(Impl& server) noexcept : m_server(server) {
            const std::lock_guard lock(server.m_mutex);
            m_draining = server.m_draining;
            if (!m_draining) ++server.m_running;
        }
        ~Running() {
            if (m_draining) return;
            const std::lock_guard lock(m_server.m_mutex);
            if (--m_server.m_running == 0) m_server.m_finished.notify_all();
        }
        Running(const Running&) = delete;
        Running& operator=(const Running&) = delete;
        [[nodiscard]] bool draining() const noexcept { return m_draining; }

    private:
        Impl& m_server;
        bool m_draining;
    };

    Router& m_router;
    const ServerOptions m_options;
    mg_context* m_context = nullptr;
    int m_port = 0;
    std::string m_last_message;
    std::atomic<int> m_connections{0};
    std::mutex m_mutex;
    std::condition_variable m_finished;
    int m_running = 0;
    bool m_started = false, m_draining = false;
};

Server::Server(Router& router, const ServerOptions& options) : m_impl(std::make_unique<Impl>(router, options)) {}
Server::~Server() = default;
int Server::port() const noexcept { return m_impl->port(); }
std::string Server::url() const { return m_impl->url(); }
void Server::stop() noexcept { m_impl->stop(); }

}  // namespace terravox::http
