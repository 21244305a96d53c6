#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "voxelserver/http/router.hpp"

namespace terravox::http {

struct ServerOptions {
    std::string bind = "127.0.0.1";  ///< numeric address
    int port = 8888;                 ///< 0 = any free one
    /// Connections served at the same time, each by a thread of its own; at least 1. A waiting
    /// thread costs little.
    int request_threads = 128;
    std::chrono::milliseconds request_timeout{
        5'000};  ///< for a whole header, for a whole body, and for each bit of progress of a reply
    std::chrono::milliseconds keep_alive_timeout{2'000};  ///< between two requests of a connection
    /// With a client that does not finish its request, when more than seven eighths of the threads
    /// are taken.
    std::chrono::milliseconds timeout{500};
    std::chrono::milliseconds drain_timeout{
        10'000};                  ///< for the replies that are under way when stop() is called
    std::string tls_certificate;  ///< PEM file with a certificate, its chain and its private key;
                                  ///< "" = no TLS
};

/// @throws UsageError for a bind that is no address, or a certificate that is no file; Error naming
/// the port when it cannot be listened on
void check_can_listen(const ServerOptions& options);

/// Serves a router over HTTP/1.1, with TLS 1.2 or newer where there is a certificate (CivetWeb).
///
/// When all request threads are taken, up to 128 accepted connections wait for one, then 200 more
/// in the kernel: CivetWeb 1.15 has no reply of its own for that, it stops accepting. Connections
/// are then closed after each reply, so that the waiting ones get their turn. Clients that do not
/// finish a request (or say nothing between two) cannot keep the threads from others: see
/// net::SlowClients. Clients that read their replies slowly still can; for those a proxy belongs
/// before a server that faces the internet. The 503 of the interface comes from the router, whose
/// limit is to be lower than request_threads. A header beyond 16 KiB: 400 (as CivetWeb 1.15 has
/// it); 64 or more header fields: 431. A body is read when all else about the request is right.
class Server {
public:
    /// Listens and answers from here on. The router must outlive the server. @throws as
    /// check_can_listen
    Server(Router& router, const ServerOptions& options);
    ~Server();
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    [[nodiscard]] int port() const noexcept;
    [[nodiscard]] std::string url() const;  ///< http://address:port, or https://

    /// Answers new requests with 503, lets the running ones finish (drain_timeout at most), then
    /// closes everything, for which it waits. Takes up to two seconds when idle: CivetWeb's threads
    /// look up that often. Idempotent; not for several threads at once.
    /// @param time_is_up called when the time for running requests is over, done or not: to end
    /// those that would take longer
    void stop(const std::function<void()>& time_is_up = {}) noexcept;

private:
    class Impl;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace terravox::http
