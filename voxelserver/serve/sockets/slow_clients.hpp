#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>

namespace terravox::sockets {

/// Prevents clients that do not finish their requests from occupying all threads of an HTTP server
/// with one thread per connection (CivetWeb). While more connections than a limit are open, those
/// that have waited for their client longer than a timeout (for the rest of a request, of a TLS
/// handshake, or for the next request) are closed: first those of the address that has the most of
/// them, the longest-waiting first. A connection with unread bytes waits for the server, not for
/// its client, and stays open; so does one whose request is being answered.
///
/// The server library exposes neither the descriptors of its connections nor the number of those
/// that wait for a thread. Therefore a thread of this class scans the descriptors of the process a
/// few times a second and identifies the connections by the port. It closes none itself: it
/// duplicates a descriptor, verifies that it is still the same connection, and shuts the connection
/// down; the library then reads the end of the stream. The mutex guards the list of known
/// connections; it is held during the scan and, briefly, at the beginning and the end of every
/// request.
class SlowClients {
public:
    struct Limits {
        int connections = 1;  ///< number that may be open before any is closed; at least 1
        std::chrono::milliseconds timeout{500};  ///< time to wait for a client, while more are open
    };
    explicit SlowClients(const Limits& limits);
    ~SlowClients();  ///< no Answering may exist any more
    /// Starts the scans, until the destruction of this object. Must be called at most once.
    /// @param port that the server listens on, at any address
    /// @throws std::system_error when no thread can be started
    void watch(int port);
    SlowClients(const SlowClients&) = delete;
    SlowClients& operator=(const SlowClients&) = delete;

    /// RAII: marks a complete request that is being answered. Thread-safe.
    class Answering {
    public:
        /// @param address of the client, numeric
        Answering(SlowClients& clients, const std::string& address, int port);
        ~Answering();
        Answering(const Answering&) = delete;
        Answering& operator=(const Answering&) = delete;

    private:
        SlowClients& m_clients;
        const std::string m_name;
    };

    /// Number of connections closed so far.
    [[nodiscard]] std::uint64_t closed() const noexcept { return m_closed; }

private:
    struct Known;

    void begin(const std::string& name);
    void end(const std::string& name) noexcept;
    void run() noexcept;
    void scan();
    void log_closed(const std::string& address);

    const Limits m_limits;
    int m_port = 0;
    std::atomic<std::uint64_t> m_closed{0};
    const std::unique_ptr<Known> m_known;
    std::thread m_thread;
};

}  // namespace terravox::sockets
