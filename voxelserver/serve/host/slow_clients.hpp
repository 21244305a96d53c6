#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>
#include <unordered_map>

namespace terravox::http {

/// Closes connections that keep a thread of a Host waiting for their client, while too many
/// connections are open.
///
/// A connection waits for its client when all bytes of the client have been read and no request is
/// being answered: for the rest of a request or of a TLS handshake, or for the next request. Those
/// that have waited for longer than a timeout are closed: first those of the address that has the
/// most of them, the longest-waiting first.
///
/// How: CivetWeb says neither which sockets it has nor which of them wait. A thread therefore looks
/// for the sockets of the process that are connected to the port, ten times a second. It shuts them
/// down rather than close them: they stay CivetWeb's, which then reads the end of the stream.
class SlowClients {
public:
    /// @param max_connections number that may be open before any is closed; at least 1
    /// @param timeout time to wait for a client, while more are open
    SlowClients(int max_connections, std::chrono::milliseconds timeout);
    ~SlowClients();  ///< no Answering may exist any more
    SlowClients(const SlowClients&) = delete;
    SlowClients& operator=(const SlowClients&) = delete;

    /// Starts the thread. Must be called at most once.
    /// @param port that the host listens on, at any address
    /// @throws std::system_error when no thread can be started
    void watch(int port);

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

private:
    using Clock = std::chrono::steady_clock;
    struct Facts {
        Clock::time_point since = Clock::now();  ///< its last reply, or when it was first seen
        int answering = 0;    ///< requests; 0 or 1, except for a moment when a port is reused
        bool waited = false;  ///< for its client, when it was last looked at
        bool seen = false;    ///< whether this look has found it
    };
    void run() noexcept;
    void close_waiting();
    void log_closed(const std::string& address);

    const int m_max_connections;
    const std::chrono::milliseconds m_timeout;
    int m_port = 0;
    std::mutex m_mutex;  ///< guards m_stopping and m_connections
    std::condition_variable m_changed;
    bool m_stopping = false;
    std::unordered_map<std::string, Facts> m_connections;  ///< by Endpoint::text() of the client
    std::uint64_t m_closed = 0;  ///< this and the next are of the thread alone
    Clock::time_point m_log_again_at = Clock::time_point::min();
    std::thread m_thread;
};

}  // namespace terravox::http
