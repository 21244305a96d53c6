#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "voxelserver/serve/host/message.hpp"

namespace terravox::http {

/// Answers the requests that a Host receives, without knowing of sockets. Thread-safe.
class RequestHandler {
public:
    RequestHandler() = default;
    RequestHandler(const RequestHandler&) = delete;
    RequestHandler& operator=(const RequestHandler&) = delete;
    virtual ~RequestHandler() = default;

    /// Checks the head of a request that has a body, before that is read: bodies of unauthorised
    /// requests are not read.
    /// @return the reply to send; nullopt when the body (of as many bytes as the head declares)
    /// should be read and handle() be called with it
    [[nodiscard]] virtual std::optional<Response> refusal(const Request& request) = 0;

    /// @throws only when there is not enough memory for an error reply
    [[nodiscard]] virtual Response handle(const Request& request) = 0;

    /// The reply to what the host itself refuses: what is no proper request, or is too late.
    [[nodiscard]] virtual Response refuse(int status, const std::string& detail) {
        return problem(status, detail);
    }

    /// For statistics: bytes of a body, as sent.
    virtual void count_sent(std::uint64_t /*bytes*/) noexcept {}
};

struct HostOptions {
    std::string bind = "127.0.0.1";  ///< numeric address
    int port = 8888;                 ///< 0 = any free port
    /// Number of connections served at the same time, each by a thread of its own; at least 1. A
    /// waiting thread costs little.
    int request_threads = 128;
    int waiting_connections = 128;  ///< accepted, and waiting for a thread
    int max_header_bytes = 16'384;
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
    /// Begin and end of the message that it cannot listen.
    std::string attempt = "listen on";
    std::string advice = "; --port chooses another port, 0 any free one";
};

/// @throws UsageError for a bind address that is invalid, or a certificate that is not a file;
/// Error naming the port when it cannot be listened on
void check_can_listen(const HostOptions& options);

/// Serves what a handler answers over HTTP/1.1, with TLS 1.2 or newer if a certificate is
/// configured (CivetWeb).
///
/// When all request threads are in use, some accepted connections wait for one, then 200 more in
/// the kernel: CivetWeb 1.15 sends no reply in that case, it stops accepting. Connections are then
/// closed after each reply, so that the waiting ones are served. Clients that do not finish a
/// request (or are idle between two) cannot block the threads: see SlowClients. Clients that read
/// their replies slowly still can; use a proxy before a host that faces the internet. A 503 of the
/// handler requires a limit of its own, lower than request_threads. A header that is too long: 400
/// (as CivetWeb 1.15 replies); 64 or more header fields: 431. A body is read only after all other
/// checks of the request have passed.
class Host {
public:
    /// Listens and serves from construction. The handler must outlive the host.
    /// @throws as check_can_listen
    Host(RequestHandler& handler, const HostOptions& options);
    ~Host();
    Host(const Host&) = delete;
    Host& operator=(const Host&) = delete;

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
