#pragma once

#include <sys/socket.h>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace terravox::sockets {

/// A host and port to connect to or to listen on.
struct Address {
    std::string host;  ///< name or numeric address; empty when listening: all interfaces
    std::uint16_t port = 0;
    /// @param text "host:port", ":port", "[v6]:port"
    /// @param default_port used where none is given; 0: a port is required
    /// @throws UsageError
    [[nodiscard]] static Address parse(const std::string& text, std::uint16_t default_port);
    [[nodiscard]] std::string text() const;
};

/// An owning file descriptor.
class Socket {
public:
    Socket() = default;
    explicit Socket(int fd) noexcept : m_fd(fd) {}
    Socket(Socket&& other) noexcept : m_fd(std::exchange(other.m_fd, -1)) {}
    Socket& operator=(Socket&& other) noexcept {
        if (this != &other) {
            close();
            m_fd = std::exchange(other.m_fd, -1);
        }
        return *this;
    }
    ~Socket() { close(); }
    [[nodiscard]] int fd() const noexcept { return m_fd; }
    [[nodiscard]] explicit operator bool() const noexcept { return m_fd >= 0; }
    [[nodiscard]] int release() noexcept { return std::exchange(m_fd, -1); }
    void close() noexcept;

private:
    int m_fd = -1;
};

/// A socket address in the kernel's format.
struct Endpoint {
    sockaddr_storage storage{};
    socklen_t size_bytes = 0;
    [[nodiscard]] const sockaddr* get() const noexcept {
        return reinterpret_cast<const sockaddr*>(&storage);
    }
    [[nodiscard]] std::uint16_t port() const noexcept;
    void set_port(std::uint16_t port) noexcept;
    /// "192.0.2.7:51234", "[2001:db8::1]:51234"; without scope; IPv4-mapped IPv6 addresses as IPv4.
    [[nodiscard]] std::string text() const;
    /// A key that one peer cannot easily have many of, for limits per client: the IPv4 address, or
    /// the upper 64 bits of an IPv6 one.
    [[nodiscard]] std::string neighbourhood() const;
};

/// @param host IPv4 or IPv6, without brackets or scope
/// @return nullopt for what is no numeric address
[[nodiscard]] std::optional<Endpoint> numeric_endpoint(const std::string& host,
                                                       std::uint16_t port) noexcept;

/// Endpoint::neighbourhood() of an address in the format of Endpoint::text(); for any other text,
/// the part before its last colon.
[[nodiscard]] std::string to_neighbourhood(const std::string& peer);

using Deadline = std::chrono::steady_clock::time_point;

/// Resolves a name to all its addresses.
/// @param to_listen for binding: addresses of this machine
/// @throws Error for an unknown name
[[nodiscard]] std::vector<Endpoint> resolve(const Address& address, bool to_listen);

/// Opens listening, non-blocking sockets, all on one port: without a host, one for both families
/// where the machine has both, else one for each address of the name.
/// @throws Error
[[nodiscard]] std::vector<Socket> listen_at(const Address& address);

/// @return a connected socket, non-blocking
/// @throws Error when the connection is refused, or not established by the deadline
[[nodiscard]] Socket connect_to(const Endpoint& endpoint, Deadline deadline);

/// Sets socket options for low latency: small frames are sent at once; the kernel buffers little
/// unsent data, so that pings are not stuck behind it; a peer that acknowledges nothing for
/// `lost_after` is disconnected.
void tune(int fd, std::chrono::milliseconds lost_after) noexcept;

/// @throws Error when the peer closes the connection or the deadline passes before all bytes were
/// read
void read_exactly(int fd, void* to, std::size_t size_bytes, Deadline deadline);
/// @throws Error
void write_all(int fd, const void* from, std::size_t size_bytes, Deadline deadline);

}  // namespace terravox::sockets
