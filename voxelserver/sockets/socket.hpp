#pragma once

#include <sys/socket.h>

#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "voxelserver/sockets/address.hpp"

namespace terravox::sockets {

/// A file descriptor with an owner.
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

/// An address that the kernel takes.
struct Endpoint {
    sockaddr_storage storage{};
    socklen_t size_bytes = 0;
    [[nodiscard]] const sockaddr* get() const noexcept {
        return reinterpret_cast<const sockaddr*>(&storage);
    }
    [[nodiscard]] std::uint16_t port() const noexcept;
    void set_port(std::uint16_t port) noexcept;
    /// "192.0.2.7:51234", "[2001:db8::1]:51234"; without scope; IPv4 within IPv6 as IPv4.
    [[nodiscard]] std::string text() const;
    /// What one peer cannot easily have many of: the IPv4 address, the upper 64 bits of an IPv6
    /// one.
    [[nodiscard]] std::string neighbourhood() const;
};

/// Endpoint::neighbourhood of an address that is written as Endpoint::text does; of any other text
/// what stands before its last colon.
[[nodiscard]] std::string neighbourhood_of(const std::string& peer);

using Deadline = std::chrono::steady_clock::time_point;

/// All addresses of a name; to bind to those of this machine where `to_listen`. @throws Error for a
/// name that is not known
[[nodiscard]] std::vector<Endpoint> resolve(const Address& address, bool to_listen);

/// Sockets that listen, non-blocking, all on one port: for no host one of both families where the
/// machine has both, else one for each address of the name. @throws Error
[[nodiscard]] std::vector<Socket> listen_at(const Address& address);

/// @return a connected socket, non-blocking @throws Error: nobody listens there, or no answer by
/// then
[[nodiscard]] Socket connect_to(const Endpoint& endpoint, Deadline deadline);

/// Small frames go at once; the kernel holds little that is not on its way, so that pings are not
/// stuck behind it; a peer that confirms nothing for so long is lost.
void tune(int fd, std::chrono::milliseconds lost_after) noexcept;

/// @throws Error when the peer closes or the time is over before all bytes are there
void read_exactly(int fd, void* to, std::size_t size_bytes, Deadline deadline);
/// @throws Error
void write_all(int fd, const void* from, std::size_t size_bytes, Deadline deadline);

}  // namespace terravox::sockets
