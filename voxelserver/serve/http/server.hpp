#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "voxelserver/serve/http/message.hpp"

namespace terravox::http {

/// What a Server serves: answers requests without knowing of sockets. Thread-safe.
class RequestHandler {
public:
    RequestHandler() = default;
    RequestHandler(const RequestHandler&) = delete;
    RequestHandler& operator=(const RequestHandler&) = delete;
    virtual ~RequestHandler() = default;

    /// Checks the head of a request, without its body. Must be called before the body is read:
    /// bodies of unauthorised requests are not read.
    /// @return the reply to send; nullopt when the body (of as many bytes as the head declares)
    /// should be read and handle() be called with it
    [[nodiscard]] virtual std::optional<Response> refusal(const Request& request) = 0;

    /// @throws only when there is not enough memory for an error reply
    [[nodiscard]] virtual Response handle(const Request& request) = 0;

    /// For statistics: a request that the server itself has refused, and bytes of bodies, as sent.
    virtual void count_refused(int status) noexcept = 0;
    virtual void count_sent(std::uint64_t bytes) noexcept = 0;
};

struct ServerOptions {
    std::string bind = "127.0.0.1";  ///< numeric address
    int port = 8888;                 ///< 0 = any free port
    /// Number of connections served at the same time, each by a thread of its own; at least 1. A
    /// waiting thread costs little.
    int request_threads = 128;
    /// Timeout for a whole header, for a whole body, and for each bit of progress of a reply.
    std::chrono::milliseconds request_timeout{5'000};
    /// Timeout between two requests of a connection.
    std::chrono::milliseconds keep_alive_timeout{2'000};
    /// Timeout for clients that do not finish their request, when more than seven eighths of the
    /// threads are in use.
    std::chrono::milliseconds timeout{500};
    /// Timeout for the replies in progress when stop() is called.
    std::chrono::milliseconds drain_timeout{10'000};
    /// PEM file with the certificate, its chain and its private key; "" = no TLS.
    std::string tls_certificate;
};

/// @throws UsageError for a bind address that is invalid, or a certificate that is not a file;
/// Error naming the port when it cannot be listened on
void check_can_listen(const ServerOptions& options);

/// Serves what a handler answers over HTTP/1.1, with TLS 1.2 or newer if a certificate is
/// configured (CivetWeb).
///
/// When all request threads are in use, up to 128 accepted connections wait for one, then 200 more
/// in the kernel: CivetWeb 1.15 sends no reply in that case, it stops accepting. Connections are
/// then closed after each reply, so that the waiting ones are served. Clients that do not finish a
/// request (or are idle between two) cannot block the threads: see sockets::SlowClients. Clients
/// that read their replies slowly still can; use a proxy before a server that faces the internet.
/// A 503 of the handler requires a limit of its own, lower than request_threads. A
/// header beyond 16 KiB: 400 (as CivetWeb 1.15 replies); 64 or more header fields: 431. A body is
/// read only after all other checks of the request have passed.
class Server {
public:
    /// Listens and serves from construction. The handler must outlive the server.
    /// @throws as check_can_listen
    Server(RequestHandler& handler, const ServerOptions& options);
    ~Server();
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    [[nodiscard]] int port() const noexcept;
    [[nodiscard]] std::string url() const;  ///< http://address:port, or https://

    /// Answers new requests with 503, lets the running ones finish (for at most drain_timeout),
    /// then closes everything and waits for that. Takes up to two seconds when idle: CivetWeb's
    /// threads poll that often. Idempotent; must not be called by several threads at once.
    /// @param after_drain called when the time for running requests has passed, whether they have
    /// finished or not: to cancel those that would take longer
    void stop(const std::function<void()>& after_drain = {}) noexcept;

private:
    class Impl;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace terravox::http
