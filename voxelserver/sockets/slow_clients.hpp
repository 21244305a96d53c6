#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>

namespace terravox::sockets {

/// Keeps clients that do not finish their requests from taking all threads of an HTTP server that
/// gives each connection a thread (CivetWeb). While more connections than a limit are open, those
/// that wait for their client (for the rest of a request, of a TLS handshake, or for the next
/// request) and have done so for a while are closed: first those of the address that has the most
/// of them, the longest-waiting first. A connection whose bytes nobody has read yet waits for the
/// server, not for its client, and stays; so does one whose request is being answered.
///
/// The server library tells neither the descriptors of its connections nor how many wait for a
/// thread. So one thread of this class looks at the descriptors of the process a few times a second
/// and finds the connections by the port. It closes none itself: it duplicates a descriptor, looks
/// whether that is still the same connection, and shuts the connection down; the library then reads
/// its end. The mutex guards the list of what is known of connections; it is held by the look and,
/// shortly, by begin and end of every request.
class SlowClients {
public:
    struct Limits {
        int connections = 1;  ///< that may be open before any is closed; at least 1
        std::chrono::milliseconds timeout{500};  ///< with a client, while there are more
    };
    explicit SlowClients(const Limits& limits);
    ~SlowClients();  ///< no Answering may be left
    /// Begins to look, until the end of this object. To be called once.
    /// @param port that the server listens on, at whatever address
    /// @throws std::system_error when no thread can be started
    void watch(int port);
    SlowClients(const SlowClients&) = delete;
    SlowClients& operator=(const SlowClients&) = delete;

    /// A request that is whole and is being answered, as long as this lives. Thread-safe.
    class Answering {
    public:
        /// @param address numeric, of the client
        Answering(SlowClients& clients, const std::string& address, int port);
        ~Answering();
        Answering(const Answering&) = delete;
        Answering& operator=(const Answering&) = delete;

    private:
        SlowClients& m_clients;
        const std::string m_name;
    };

    [[nodiscard]] std::uint64_t closed() const noexcept {
        return m_closed;
    }  ///< connections so far

private:
    struct Known;

    void begin(const std::string& name);
    void end(const std::string& name) noexcept;
    void run() noexcept;
    void look();
    void tell(const std::string& address);

    const Limits m_limits;
    int m_port = 0;
    std::atomic<std::uint64_t> m_closed{0};
    const std::unique_ptr<Known> m_known;
    std::thread m_thread;
};

}  // namespace terravox::sockets
