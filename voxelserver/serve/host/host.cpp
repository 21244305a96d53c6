#include "voxelserver/serve/host/host.hpp"

#include <civetweb.h>
#include <sys/socket.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <vector>

#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "common/util/log.hpp"
#include "common/util/stage_times.hpp"
#include "voxelserver/serve/host/send_reply.hpp"
#include "voxelserver/serve/host/slow_clients.hpp"
#include "voxelserver/serve/sockets/socket.hpp"

namespace terravox::http {
namespace {

constexpr const char* kTlsOldest = "4";  // CivetWeb's number for TLS 1.2

// Sent where there is no memory for a reply.
constexpr std::string_view kLastResort =
    "HTTP/1.1 500 Internal Server Error\r\nContent-Type: "
    "application/problem+json\r\nContent-Length: 68\r\nConnection: close\r\n\r\n"
    "{\"type\":\"about:blank\",\"title\":\"Internal Server Error\",\"status\":500}\n";
static_assert(kLastResort.size() - kLastResort.find('{') == 68);

std::string to_text(const std::string& address, int port) {
    return sockets::Address{address, static_cast<std::uint16_t>(port)}.text();
}

[[noreturn]] void fail_to_listen(const HostOptions& o, const std::string& why) {
    throw util::Error(o.attempt + " " + to_text(o.bind, o.port) + ": " + why + o.advice);
}

sockets::Endpoint to_endpoint(const HostOptions& o) {
    if (o.port < 0 || o.port > 65535)
        throw util::UsageError("listen: port " + std::to_string(o.port) + "; allowed: 0 to 65535");
    const auto out = sockets::numeric_endpoint(o.bind, static_cast<std::uint16_t>(o.port));
    if (!out)
        throw util::UsageError(
            o.attempt + " '" + o.bind +
            "': not an address; allowed: numbers, such as 127.0.0.1 (this machine) or "
            "0.0.0.0 (all networks)");
    if (out->storage.ss_family == AF_INET6 && mg_check_feature(MG_FEATURES_IPV6) == 0)
        throw util::UsageError(o.attempt + " " + o.bind +
                               ": this build of CivetWeb has no IPv6; allowed: IPv4");
    return *out;
}

/// An option of CivetWeb.
struct Setting {
    const char* name;
    std::string value;
};

// There is no document_root: CivetWeb serves no files. Its check of Host against a domain is not
// used: a handler has names of its own.
std::vector<Setting> make_settings(const HostOptions& options) {
    const bool secure = !options.tls_certificate.empty();
    std::vector<Setting> out = {
        {"listening_ports", to_text(options.bind, options.port) + (secure ? "s" : "")},
        {"num_threads", std::to_string(std::max(options.request_threads, 1))},
        {"connection_queue", std::to_string(options.waiting_connections)},
        {"max_request_size", std::to_string(options.max_header_bytes)},
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

// OpenSSL, which takes milliseconds to load, is loaded only when it is needed. When CivetWeb opens
// its TLS library, the dynamic linker returns the one of missing_symbol.c, which is already loaded
// under that name.
void init_library(bool with_tls) {
    static std::once_flag plain;
    static std::once_flag secure;
    std::call_once(plain, [] { mg_init_library(MG_FEATURES_DEFAULT); });
    if (!with_tls)
        return;
    std::call_once(secure, [] {
        (void)util::open_module(TERRAVOX_TLS_LIBRARY, "TLS library");
        mg_init_library(MG_FEATURES_TLS);
    });
}

/// What a client has asked, in our own form. The views live as long as `info`.
Request make_request(const mg_request_info& info) {
    Request out;
    out.method = info.request_method;
    if (info.local_uri_raw != nullptr)
        out.path = info.local_uri_raw;  // not decoded: handlers decide about escapes
    if (info.query_string != nullptr)
        out.query = info.query_string;
    if (info.http_version != nullptr)
        out.version = info.http_version;
    out.client = info.remote_addr;
    out.headers.reserve(static_cast<std::size_t>(info.num_headers));
    for (int i = 0; i < info.num_headers; ++i)
        out.headers.push_back({info.http_headers[i].name, info.http_headers[i].value});
    return out;
}

/// Reads a body of a known length.
/// @return false when it was not received in time, or is incomplete
bool read_body(mg_connection* connection, std::uint64_t bytes, std::chrono::milliseconds timeout,
               std::string& body) {
    const auto give_up = std::chrono::steady_clock::now() + timeout;
    body.resize(bytes);
    std::size_t have = 0;
    while (have < bytes) {
        const int n = mg_read(connection, body.data() + have, bytes - have);
        if (n <= 0 || std::chrono::steady_clock::now() > give_up)
            return false;
        have += static_cast<std::size_t>(n);
    }
    return true;
}

// An unread body must not be parsed as the next request.
bool leaves_body_unread(const Request& request) {
    const BodyClaim claim = body_claim(request);
    return claim.kind == BodyClaim::Kind::kMalformed || claim.bytes != request.body.size();
}

bool write_bytes(mg_connection* connection, std::string_view bytes) noexcept {
    return bytes.empty() ||
           mg_write(connection, bytes.data(), bytes.size()) == static_cast<int>(bytes.size());
}

struct StopCivetWeb {
    void operator()(mg_context* context) const noexcept { mg_stop(context); }
};

}  // namespace

void check_can_listen(const HostOptions& options) {
    if (!options.tls_certificate.empty() && access(options.tls_certificate.c_str(), R_OK) != 0)
        throw util::UsageError("read the TLS certificate " + options.tls_certificate + ": " +
                               std::strerror(errno) +
                               "; allowed: a PEM file with certificate and private key");
    const sockets::Endpoint endpoint = to_endpoint(options);
    const sockets::Socket probe(
        ::socket(endpoint.storage.ss_family, SOCK_STREAM | SOCK_CLOEXEC, 0));
    const int on = 1;  // as CivetWeb has it
    if (!probe || ::setsockopt(probe.fd(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) != 0 ||
        ::bind(probe.fd(), endpoint.get(), endpoint.size_bytes) != 0)
        fail_to_listen(options, std::strerror(errno));
}

/// CivetWeb calls back on its own threads, through C: callbacks must not throw. One lock guards the
/// count of running requests, the flag and the message; it is not held while a request is answered.
/// For m_slow_clients a request is being answered only from its last byte on: a client that sends
/// its body slowly is treated like one that sends its header slowly.
class Host::Impl {
public:
    Impl(RequestHandler& handler, const HostOptions& options)
        : m_handler(handler),
          m_options(options),
          m_threads(std::max(options.request_threads, 1)),
          // An eighth of the threads, at least one, stays free of slow clients.
          m_slow_clients(std::max(m_threads - (m_threads + 7) / 8, 1), options.timeout) {
        check_can_listen(options);
        init_library(!options.tls_certificate.empty());
        start();
        m_slow_clients.watch(m_port);
    }

    ~Impl() { stop({}); }

    [[nodiscard]] int port() const noexcept { return m_port; }
    [[nodiscard]] std::string url() const {
        return (m_options.tls_certificate.empty() ? "http://" : "https://") +
               to_text(m_options.bind, m_port);
    }

    void stop(const std::function<void()>& after_drain) noexcept {
        if (!m_context)
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
        m_context.reset();
    }

private:
    /// Starts CivetWeb: from then on it answers requests.
    /// @throws Error when it cannot start, with its last message
    void start() {
        mg_callbacks callbacks{};
        callbacks.init_thread = new_buffer;
        callbacks.exit_thread = delete_buffer;
        callbacks.begin_request = on_request;
        callbacks.http_error = on_refusal;
        callbacks.log_message = on_log;
        callbacks.init_connection = on_connection;
        callbacks.connection_close = on_connection_close;
        const std::vector<Setting> settings = make_settings(m_options);
        std::vector<const char*> words;
        for (const Setting& setting : settings) {
            words.push_back(setting.name);
            words.push_back(setting.value.c_str());
        }
        words.push_back(nullptr);
        m_context.reset(mg_start(&callbacks, this, words.data()));
        if (!m_context)
            fail_to_start();
        mg_server_port port{};
        if (mg_get_server_ports(m_context.get(), 1, &port) == 1)
            m_port = port.port;
    }

    [[noreturn]] void fail_to_start() const {
        const std::string why =
            m_last_message.empty() ? "CivetWeb could not start" : m_last_message;
        if (!m_options.tls_certificate.empty())
            throw util::Error("serve with the certificate " + m_options.tls_certificate + ": " +
                              why + "; allowed: a PEM file with certificate and private key");
        fail_to_listen(m_options, why);
    }

    static Impl& self(const mg_connection* connection) noexcept {
        return *static_cast<Impl*>(mg_get_user_data(mg_get_context(connection)));
    }

    // A buffer of each thread for replies.
    static void* new_buffer(const mg_context* /*context*/, int /*thread*/) noexcept {
        return new std::string;
    }
    static void delete_buffer(const mg_context* /*context*/, int /*thread*/,
                              void* buffer) noexcept {
        delete static_cast<std::string*>(buffer);
    }

    // @return the status that was sent: CivetWeb then does nothing more about the request
    static int on_request(mg_connection* connection) noexcept {
        Impl& host = self(connection);
        const bool is_in_time = host.begin();
        const int status = host.answer(connection, !is_in_time);
        if (is_in_time)
            host.end();
        return status;
    }

    // Replies for requests that CivetWeb itself refuses. 1.15 reports a header that is too long,
    // too slow or truncated as a malformed message (400); where a version uses 413 for the first,
    // that is about the header, for which 431 is the proper status.
    static int on_refusal(mg_connection* connection, int status, const char* message) noexcept {
        try {
            Impl& host = self(connection);
            util::log_debug("refused: {} {}", status, message != nullptr ? message : "");
            std::string detail =
                std::string("read the request: ") + (message != nullptr ? message : "refused");
            if (status == 400 || status == 413)
                detail += "; allowed: HTTP/1.1, a header of up to " +
                          std::to_string(host.m_options.max_header_bytes) +
                          " bytes, sent without delay";
            (void)send(connection, host.refuse(status == 413 ? 431 : status, detail), {}, false);
        } catch (...) {
            send_last_resort(connection);
        }
        return 0;
    }

    static int on_log(const mg_connection* connection, const char* message) noexcept {
        try {
            util::log_debug("CivetWeb: {}", message);
            Impl& host = self(connection);
            const std::lock_guard lock(host.m_mutex);
            if (host.m_port == 0)
                host.m_last_message = message;
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

    /// @param request what it answers, as far as that is known
    /// @return number of bytes of the body that were sent
    static std::uint64_t send(mg_connection* connection, const Response& reply,
                              const Request& request, bool keep_alive) {
        std::string& buffer = *static_cast<std::string*>(mg_get_thread_pointer(connection));
        const Write write = [&](std::string_view bytes) { return write_bytes(connection, bytes); };
        const SentReply sent = send_reply(write, buffer, reply, request.method == "HEAD",
                                          keep_alive, request.version == "1.0");
        // Closing also prevents CivetWeb from reading (and waiting for) a body of any length that
        // the client has announced.
        if (!sent.keep_alive)
            mg_disable_connection_keep_alive(connection);
        return sent.body_bytes;
    }

    static void send_last_resort(mg_connection* connection) noexcept {
        (void)write_bytes(connection, kLastResort);
        mg_disable_connection_keep_alive(connection);
    }

    /// Counts a request that stop() waits for.
    /// @return false when it came after stop() was called
    bool begin() noexcept {
        const std::lock_guard lock(m_mutex);
        m_running += m_draining ? 0 : 1;
        return !m_draining;
    }
    void end() noexcept {
        const std::lock_guard lock(m_mutex);
        if (--m_running == 0)
            m_finished.notify_all();
    }

    int answer(mg_connection* connection, bool draining) noexcept {
        try {
            const mg_request_info& info = *mg_get_request_info(connection);
            Request request = make_request(info);
            const util::Stopwatch clock;
            std::string body;
            std::optional<Response> refused;
            if (draining)
                refused = refuse(503, "the server is shutting down").add("Retry-After", "5");
            else
                refused = read_request(connection, request, body);
            std::optional<SlowClients::Answering> answering;
            if (!refused)
                answering.emplace(m_slow_clients, info.remote_addr, info.remote_port);
            const Response out = refused ? std::move(*refused) : m_handler.handle(request);
            const bool others_wait = m_connections >= m_options.request_threads;
            const bool keep_alive = !out.close && !others_wait && wants_keep_alive(request) &&
                                    !leaves_body_unread(request);
            m_handler.count_sent(send(connection, out, request, keep_alive));
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

    /// The reply to a request that is not passed to the handler.
    Response refuse(int status, const std::string& detail) {
        Response out = m_handler.refuse(status, detail);
        out.close = true;
        return out;
    }

    /// Reads the body into `body`, unless the request can be refused by its head alone.
    /// @return the reply to send in that case
    std::optional<Response> read_request(mg_connection* connection, Request& request,
                                         std::string& body) {
        // CivetWeb ignores further headers: one of them could announce a body, which would then be
        // parsed as the next request.
        if (request.headers.size() >= MG_MAX_HEADERS)
            return refuse(
                431, "read the request: " + std::to_string(MG_MAX_HEADERS) + " or more headers");
        const BodyClaim claim = body_claim(request);
        if (claim.kind != BodyClaim::Kind::kSome)
            return std::nullopt;
        if (auto refused = m_handler.refusal(request))
            return refused;
        if (same_word(request.header("Expect"), "100-continue"))
            (void)write_bytes(connection, "HTTP/1.1 100 Continue\r\n\r\n");
        if (!read_body(connection, claim.bytes, m_options.request_timeout, body))
            return refuse(408, "read the request: its body was not received, or not in " +
                                   std::to_string(m_options.request_timeout.count() / 1000.0) +
                                   " s");
        request.body = body;
        return std::nullopt;
    }

    RequestHandler& m_handler;
    const HostOptions m_options;
    const int m_threads;
    std::atomic<int> m_port{0};  ///< 0 until it has started
    std::string m_last_message;
    std::atomic<int> m_connections{0};
    SlowClients m_slow_clients;
    std::mutex m_mutex;
    std::condition_variable m_finished;
    int m_running = 0;
    bool m_draining = false;
    std::unique_ptr<mg_context, StopCivetWeb> m_context;  ///< the last: its threads use the others
};

Host::Host(RequestHandler& handler, const HostOptions& options)
    : m_impl(std::make_unique<Impl>(handler, options)) {}
Host::~Host() = default;
int Host::port() const noexcept {
    return m_impl->port();
}
std::string Host::url() const {
    return m_impl->url();
}
void Host::stop(const std::function<void()>& after_drain) noexcept {
    m_impl->stop(after_drain);
}

}  // namespace terravox::http
