#include "voxelserver/serve/http/server.hpp"

#include <arpa/inet.h>
#include <civetweb.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <optional>
#include <vector>

#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/util/stage_times.hpp"
#include "voxelserver/serve/http/connection_io.hpp"
#include "voxelserver/serve/sockets/slow_clients.hpp"
#include "voxelserver/serve/tls/tls_library.hpp"

namespace terravox::http {
namespace {

constexpr const char* kMaxHeaderBytes = "16384";
constexpr const char* kConnectionQueue = "128";
constexpr const char* kTlsOldest = "4";  // CivetWeb's number for TLS 1.2

bool is_ipv6(const std::string& address) {
    return address.find(':') != std::string::npos;
}

std::string endpoint(const std::string& address, int port) {
    return (is_ipv6(address) ? "[" + address + "]" : address) + ":" + std::to_string(port);
}

[[noreturn]] void fail_to_listen(const ServerOptions& o, const std::string& why) {
    throw util::Error("listen on " + endpoint(o.bind, o.port) + ": " + why +
                      "; --port chooses another port, 0 any free one");
}

struct Address {
    sockaddr_storage storage{};
    socklen_t length = 0;
};

Address to_address(const ServerOptions& o) {
    if (o.port < 0 || o.port > 65535)
        throw util::UsageError("listen: port " + std::to_string(o.port) + "; allowed: 0 to 65535");
    Address out;
    if (is_ipv6(o.bind)) {
        auto* a = reinterpret_cast<sockaddr_in6*>(&out.storage);
        a->sin6_family = AF_INET6;
        a->sin6_port = htons(static_cast<std::uint16_t>(o.port));
        out.length = sizeof *a;
        if (inet_pton(AF_INET6, o.bind.c_str(), &a->sin6_addr) == 1) {
            if (mg_check_feature(MG_FEATURES_IPV6) == 0)
                throw util::UsageError("listen on " + o.bind +
                                       ": this build of CivetWeb has no IPv6; allowed: IPv4");
            return out;
        }
    } else {
        auto* a = reinterpret_cast<sockaddr_in*>(&out.storage);
        a->sin_family = AF_INET;
        a->sin_port = htons(static_cast<std::uint16_t>(o.port));
        out.length = sizeof *a;
        if (inet_pton(AF_INET, o.bind.c_str(), &a->sin_addr) == 1)
            return out;
    }
    throw util::UsageError(
        "listen on '" + o.bind +
        "': not an address; allowed: numbers, such as 127.0.0.1 (this machine) or "
        "0.0.0.0 (all networks)");
}

// Keeps an eighth of the threads, at least one, free of clients that do not finish their requests.
sockets::SlowClients::Limits make_limits(const ServerOptions& options) {
    const int threads = std::max(options.request_threads, 1);
    return {std::max(threads - (threads + 7) / 8, 1), options.timeout};
}

/// An option of CivetWeb.
struct Setting {
    const char* name;
    std::string value;
};

// There is no document_root: CivetWeb serves no files. Its check of Host against a domain is not
// used: the server has only one world.
std::vector<Setting> make_settings(const ServerOptions& options) {
    const bool secure = !options.tls_certificate.empty();
    std::vector<Setting> out = {
        {"listening_ports", endpoint(options.bind, options.port) + (secure ? "s" : "")},
        {"num_threads", std::to_string(std::max(options.request_threads, 1))},
        {"connection_queue", kConnectionQueue},
        {"max_request_size", kMaxHeaderBytes},
        {"request_timeout_ms", std::to_string(options.request_timeout.count())},
        {"keep_alive_timeout_ms", std::to_string(options.keep_alive_timeout.count())},
        {"enable_keep_alive", "yes"},
        {"tcp_nodelay", "1"},
        {"decode_url", "no"},
        {"enable_auth_domain_check", "no"}};
    if (secure) {
        out.push_back({"ssl_certificate", options.tls_certificate});
        out.push_back({"ssl_protocol_version", kTlsOldest});
    }
    return out;
}

// Replies for requests that CivetWeb itself refuses. 1.15 reports a header that is too long, too
// slow or truncated as a malformed message (400); where a version uses 413 for the first, that is
// about the header, for which 431 is the proper status.
Response refusal(int status, const char* message) {
    std::string detail =
        std::string("read the request: ") + (message != nullptr ? message : "refused");
    if (status == 400 || status == 413)
        detail += std::string("; allowed: HTTP/1.1, a header of up to ") + kMaxHeaderBytes +
                  " bytes, sent without delay";
    return problem(status == 413 ? 431 : status, detail);
}

// OpenSSL, which takes milliseconds to load, is loaded only when it is needed.
void init_library(bool with_tls) {
    static std::once_flag plain;
    static std::once_flag secure;
    std::call_once(plain, [] { mg_init_library(MG_FEATURES_DEFAULT); });
    if (!with_tls)
        return;
    std::call_once(secure, [] {
        tls::load_library();
        mg_init_library(MG_FEATURES_TLS);
    });
}

}  // namespace

void check_can_listen(const ServerOptions& options) {
    if (!options.tls_certificate.empty() && access(options.tls_certificate.c_str(), R_OK) != 0)
        throw util::UsageError("read the TLS certificate " + options.tls_certificate + ": " +
                               std::strerror(errno) +
                               "; allowed: a PEM file with certificate and private key");
    const Address address = to_address(options);
    const int probe = socket(address.storage.ss_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (probe < 0)
        fail_to_listen(options, std::strerror(errno));
    const int on = 1;
    setsockopt(probe, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);  // as CivetWeb does
    const bool bound =
        bind(probe, reinterpret_cast<const sockaddr*>(&address.storage), address.length) == 0;
    const int error = errno;
    close(probe);
    if (!bound)
        fail_to_listen(options, std::strerror(error));
}

/// CivetWeb calls back on its own threads, through C: callbacks must not throw. One lock guards the
/// count of running requests, the flags and the message; it is not held while a request is
/// answered. For m_slow_clients a request is being answered only from its last byte on: a client
/// that sends its body slowly is treated like one that sends its header slowly.
class Server::Impl {
public:
    Impl(RequestHandler& handler, const ServerOptions& options)
        : m_handler(handler), m_options(options), m_slow_clients(make_limits(options)) {
        check_can_listen(options);
        init_library(!options.tls_certificate.empty());
        start();
        watch_for_slow_clients();
    }

    ~Impl() { stop({}); }

    [[nodiscard]] int port() const noexcept { return m_port; }
    [[nodiscard]] std::string url() const {
        return (m_options.tls_certificate.empty() ? "http://" : "https://") +
               endpoint(m_options.bind, m_port);
    }

    void stop(const std::function<void()>& after_drain) noexcept {
        if (m_context == nullptr)
            return;
        {
            // mg_stop would truncate replies: let them finish first.
            std::unique_lock lock(m_mutex);
            m_draining = true;
            if (!m_finished.wait_for(lock, m_options.drain_timeout, [&] { return m_running == 0; }))
                util::log_warn("stopping with {} requests unfinished after {} s", m_running,
                               m_options.drain_timeout.count() / 1000.0);
        }
        try {
            if (after_drain)
                after_drain();
        } catch (const std::exception& e) {
            util::log_error("stop the server: {}", e.what());
        }
        mg_stop(m_context);
        m_context = nullptr;
    }

private:
    /// Starts CivetWeb: from then on it answers requests.
    /// @throws Error when it cannot start, with its last message
    void start() {
        const mg_callbacks callbacks = callbacks_of_this();
        const std::vector<Setting> settings = make_settings(m_options);
        std::vector<const char*> words;
        for (const Setting& setting : settings) {
            words.push_back(setting.name);
            words.push_back(setting.value.c_str());
        }
        words.push_back(nullptr);
        m_context = mg_start(&callbacks, this, words.data());
        if (m_context == nullptr)
            fail_to_start();
        {
            const std::lock_guard lock(m_mutex);
            m_started = true;
        }
        mg_server_port port{};
        if (mg_get_server_ports(m_context, 1, &port) == 1)
            m_port = port.port;
    }

    static mg_callbacks callbacks_of_this() noexcept {
        mg_callbacks out{};
        out.init_thread = new_buffer;
        out.exit_thread = delete_buffer;
        out.begin_request = on_request;
        out.http_error = on_refusal;
        out.log_message = on_log;
        out.init_connection = on_connection;
        out.connection_close = on_connection_close;
        return out;
    }

    [[noreturn]] void fail_to_start() const {
        const std::string why =
            m_last_message.empty() ? "CivetWeb could not start" : m_last_message;
        if (!m_options.tls_certificate.empty())
            throw util::Error("serve with the certificate " + m_options.tls_certificate + ": " +
                              why + "; allowed: a PEM file with certificate and private key");
        fail_to_listen(m_options, why);
    }

    void watch_for_slow_clients() {
        try {
            m_slow_clients.watch(m_port);
        } catch (...) {
            mg_stop(m_context);  // its threads use this object
            throw;
        }
    }

    static Impl& self(const mg_connection* connection) noexcept {
        return *static_cast<Impl*>(mg_get_user_data(mg_get_context(connection)));
    }

    // A buffer per thread for replies that are sent as a whole: allocating it for each of them
    // would cost page faults.
    static void* new_buffer(const mg_context* /*context*/, int /*thread*/) noexcept {
        return new std::string;
    }
    static void delete_buffer(const mg_context* /*context*/, int /*thread*/,
                              void* buffer) noexcept {
        delete static_cast<std::string*>(buffer);
    }

    static int on_request(mg_connection* connection) noexcept {
        return self(connection).handle(connection);
    }

    static int on_refusal(mg_connection* connection, int status, const char* message) noexcept {
        try {
            const Response out = refusal(status, message);
            self(connection).m_handler.count_refused(out.status);
            util::log_debug("refused: {} {}", out.status, message != nullptr ? message : "");
            send_response(connection, out, false);
        } catch (...) {
            send_last_resort(connection);
        }
        return 0;
    }

    static int on_log(const mg_connection* connection, const char* message) noexcept {
        try {
            util::log_debug("CivetWeb: {}", message);
            Impl& me = self(connection);
            const std::lock_guard lock(me.m_mutex);
            if (!me.m_started)
                me.m_last_message = message;
        } catch (...) {
        }
        return 1;
    }

    static int on_connection(const mg_connection* connection, void** /*data*/) noexcept {
        ++self(connection).m_connections;
        return 0;
    }

    static void on_connection_close(const mg_connection* connection) noexcept {
        --self(connection).m_connections;
    }

    // @return the status that was sent: CivetWeb then does nothing more about the request
    int handle(mg_connection* connection) noexcept {
        const Running running(*this);
        try {
            const mg_request_info& info = *mg_get_request_info(connection);
            Request request = make_request(info);
            const util::Stopwatch clock;
            std::string body;
            std::optional<Response> refused =
                running.draining() ? shutting_down() : refuse(info, request);
            if (!refused && body_claim(request).kind == BodyClaim::Kind::kSome)
                refused = take_body(connection, request, body);
            std::optional<sockets::SlowClients::Answering> answering;
            if (!refused)
                answering.emplace(m_slow_clients, info.remote_addr, info.remote_port);
            const Response out = refused ? std::move(*refused) : m_handler.handle(request);
            const bool others_wait = m_connections >= m_options.request_threads;
            const bool keep_alive =
                !out.close && !others_wait && wants_keep_alive(request, info.http_version);
            m_handler.count_sent(send_response(connection, out, keep_alive,
                                               std::string_view(info.http_version) == "1.0"));
            if (util::is_logged(util::LogLevel::kDebug))
                util::log_debug("{} {} {} {:.1f} ms", request.method, request.path, out.status,
                                clock.seconds() * 1e3);
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
            util::log_error("answer a request: {}", what);
        } catch (...) {
        }
    }

    std::optional<Response> refuse(const mg_request_info& info, const Request& request) {
        if (info.num_headers >= MG_MAX_HEADERS)
            return too_many_headers();
        if (!request.has_header("Host") && std::string_view(info.http_version) == "1.1")
            return host_missing();
        return std::nullopt;
    }

    /// Reads the body into `body`, unless the request can be refused by its head alone.
    /// @return the reply to send in that case
    std::optional<Response> take_body(mg_connection* connection, Request& request,
                                      std::string& body) {
        if (auto refused = m_handler.refusal(request))
            return refused;
        if (same_word(request.header("Expect"), "100-continue"))
            mg_printf(connection, "HTTP/1.1 100 Continue\r\n\r\n");
        if (!read_body(connection, body_claim(request).bytes, m_options.request_timeout, body))
            return body_missing();
        request.body = body;
        return std::nullopt;
    }

    Response body_missing() {
        Response out =
            problem(408, "read the request: its body was not received, or not in " +
                             std::to_string(m_options.request_timeout.count() / 1000.0) + " s");
        out.close = true;
        m_handler.count_refused(out.status);
        return out;
    }

    // Ref: RFC 9112, 3.2.
    Response host_missing() {
        Response out = problem(400, "read the request: HTTP/1.1 without the header Host");
        out.close = true;
        m_handler.count_refused(out.status);
        return out;
    }

    Response shutting_down() {
        Response out = problem(503, "the server is shutting down");
        out.add("Retry-After", "5");
        out.close = true;
        m_handler.count_refused(out.status);
        return out;
    }

    // CivetWeb ignores further headers: one of them could announce a body, which would then be
    // parsed as the next request.
    Response too_many_headers() {
        Response out = problem(
            431, "read the request: " + std::to_string(MG_MAX_HEADERS) + " or more headers");
        out.close = true;
        m_handler.count_refused(out.status);
        return out;
    }

    /// A request that stop() waits for, unless it came after stop() was called.
    class Running {
    public:
        explicit Running(Impl& server) noexcept : m_server(server) {
            const std::lock_guard lock(server.m_mutex);
            m_draining = server.m_draining;
            if (!m_draining)
                ++server.m_running;
        }
        ~Running() {
            if (m_draining)
                return;
            const std::lock_guard lock(m_server.m_mutex);
            if (--m_server.m_running == 0)
                m_server.m_finished.notify_all();
        }
        Running(const Running&) = delete;
        Running& operator=(const Running&) = delete;
        [[nodiscard]] bool draining() const noexcept { return m_draining; }

    private:
        Impl& m_server;
        bool m_draining;
    };

    RequestHandler& m_handler;
    const ServerOptions m_options;
    mg_context* m_context = nullptr;
    int m_port = 0;
    std::string m_last_message;
    std::atomic<int> m_connections{0};
    sockets::SlowClients m_slow_clients;
    std::mutex m_mutex;
    std::condition_variable m_finished;
    int m_running = 0;
    bool m_started = false;
    bool m_draining = false;
};

Server::Server(RequestHandler& handler, const ServerOptions& options)
    : m_impl(std::make_unique<Impl>(handler, options)) {}
Server::~Server() = default;
int Server::port() const noexcept {
    return m_impl->port();
}
std::string Server::url() const {
    return m_impl->url();
}
void Server::stop(const std::function<void()>& after_drain) noexcept {
    m_impl->stop(after_drain);
}

}  // namespace terravox::http
