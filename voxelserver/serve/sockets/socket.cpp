#include "voxelserver/serve/sockets/socket.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <memory>

#include "common/util/error.hpp"

namespace terravox::sockets {
namespace {

[[noreturn]] void refuse(const std::string& text, const std::string& why) {
    throw util::UsageError("read the address '" + text + "': " + why +
                           "; allowed: HOST:PORT, :PORT, [IPV6]:PORT, port 0 to 65535");
}

}  // namespace

Address Address::parse(const std::string& text, std::uint16_t default_port) {
    Address out{.host = {}, .port = default_port};
    std::string port;
    bool has_port = false;
    if (text.starts_with('[')) {
        const auto end = text.find(']');
        if (end == std::string::npos)
            refuse(text, "no ']' after '['");
        out.host = text.substr(1, end - 1);
        if (out.host.find(':') == std::string::npos)
            refuse(text, "no IPv6 address between '[' and ']'");
        const std::string rest = text.substr(end + 1);
        if (!rest.empty() && rest.front() != ':')
            refuse(text, "something after ']' that is no port");
        has_port = !rest.empty();
        if (has_port)
            port = rest.substr(1);
    } else if (const auto colon = text.find(':'); colon != std::string::npos) {
        // Ambiguous without brackets: the port of "fe80::1:80" cannot be determined.
        if (text.find(':', colon + 1) != std::string::npos)
            refuse(text, "an IPv6 address stands in brackets");
        out.host = text.substr(0, colon);
        has_port = true;
        port = text.substr(colon + 1);
    } else {
        out.host = text;
        if (text.empty())
            refuse(text, "it is empty");
    }
    for (const char c : out.host)
        if (c <= ' ' || c == '/' || c == '@' || c == 0x7f || static_cast<unsigned char>(c) >= 0x80)
            refuse(text, "a host has no such character");
    if (has_port) {
        unsigned value = 0;
        const auto [end, failed] = std::from_chars(port.data(), port.data() + port.size(), value);
        if (failed != std::errc() || end != port.data() + port.size() || value > 65535)
            refuse(text, "'" + port + "' is no port");
        out.port = static_cast<std::uint16_t>(value);
    } else if (default_port == 0) {
        refuse(text, "no port");
    }
    return out;
}

std::string Address::text() const {
    return (host.find(':') == std::string::npos ? host : "[" + host + "]") + ":" +
           std::to_string(port);
}

namespace {

constexpr int kBacklog = 1024;

const in6_addr& six(const sockaddr_storage& storage) {
    return reinterpret_cast<const sockaddr_in6*>(&storage)->sin6_addr;
}

/// The bytes of an IPv4 address or of an IPv4-mapped IPv6 address; else nullptr.
const std::uint8_t* four(const sockaddr_storage& storage) {
    if (storage.ss_family == AF_INET)
        return reinterpret_cast<const std::uint8_t*>(
            &reinterpret_cast<const sockaddr_in*>(&storage)->sin_addr);
    if (storage.ss_family == AF_INET6 && IN6_IS_ADDR_V4MAPPED(&six(storage)))
        return six(storage).s6_addr + 12;
    return nullptr;
}

std::string host_text(int family, const void* bytes) {
    std::array<char, INET6_ADDRSTRLEN> text{};
    return ::inet_ntop(family, bytes, text.data(), text.size()) != nullptr ? text.data() : "?";
}

/// @return false when the deadline has passed
bool wait_for(int fd, short events, Deadline deadline) {
    for (;;) {
        const auto left = std::chrono::ceil<std::chrono::milliseconds>(
                              deadline - std::chrono::steady_clock::now())
                              .count();
        if (left <= 0)
            return false;
        pollfd one{fd, events, 0};
        const int ready = ::poll(&one, 1, static_cast<int>(std::min<long long>(left, 60'000)));
        if (ready > 0)
            return true;
        if (ready < 0 && errno != EINTR)
            throw util::Error(std::string("wait for a socket: ") + std::strerror(errno));
    }
}

Socket listen_at(const Endpoint& endpoint, bool both_families, const std::string& where) {
    Socket socket(
        ::socket(endpoint.storage.ss_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    const auto failed = [&] {
        return util::Error("listen at " + where + ": " + std::strerror(errno));
    };
    if (!socket)
        throw failed();
    const int on = 1;
    const int only_six = both_families ? 0 : 1;
    ::setsockopt(socket.fd(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (endpoint.storage.ss_family == AF_INET6 &&
        ::setsockopt(socket.fd(), IPPROTO_IPV6, IPV6_V6ONLY, &only_six, sizeof only_six) != 0)
        throw failed();
    if (::bind(socket.fd(), endpoint.get(), endpoint.size_bytes) != 0 ||
        ::listen(socket.fd(), kBacklog) != 0)
        throw failed();
    return socket;
}

std::uint16_t bound_port(int fd) {
    Endpoint bound;
    bound.size_bytes = sizeof bound.storage;
    if (::getsockname(fd, reinterpret_cast<sockaddr*>(&bound.storage), &bound.size_bytes) != 0)
        throw util::Error(std::string("query the port of a socket: ") + std::strerror(errno));
    return bound.port();
}

}  // namespace

void Socket::close() noexcept {
    if (m_fd >= 0)
        ::close(std::exchange(m_fd, -1));
}

std::uint16_t Endpoint::port() const noexcept {
    return ntohs(storage.ss_family == AF_INET6
                     ? reinterpret_cast<const sockaddr_in6*>(&storage)->sin6_port
                     : reinterpret_cast<const sockaddr_in*>(&storage)->sin_port);
}

void Endpoint::set_port(std::uint16_t port) noexcept {
    (storage.ss_family == AF_INET6 ? reinterpret_cast<sockaddr_in6*>(&storage)->sin6_port
                                   : reinterpret_cast<sockaddr_in*>(&storage)->sin_port) =
        htons(port);
}

std::string Endpoint::text() const {
    const std::string port_text = ":" + std::to_string(port());
    if (const auto* bytes = four(storage))
        return host_text(AF_INET, bytes) + port_text;
    if (storage.ss_family == AF_INET6)
        return "[" + host_text(AF_INET6, &six(storage)) + "]" + port_text;
    return "?" + port_text;
}

std::string Endpoint::neighbourhood() const {
    if (const auto* bytes = four(storage))
        return host_text(AF_INET, bytes);
    if (storage.ss_family != AF_INET6)
        return "?";
    in6_addr upper = six(storage);
    std::memset(upper.s6_addr + 8, 0, 8);
    return host_text(AF_INET6, &upper) + "/64";
}

std::optional<Endpoint> numeric_endpoint(const std::string& host, std::uint16_t port) noexcept {
    Endpoint out;
    auto* ipv4 = reinterpret_cast<sockaddr_in*>(&out.storage);
    auto* ipv6 = reinterpret_cast<sockaddr_in6*>(&out.storage);
    if (::inet_pton(AF_INET, host.c_str(), &ipv4->sin_addr) == 1) {
        ipv4->sin_family = AF_INET;
        out.size_bytes = sizeof *ipv4;
    } else if (::inet_pton(AF_INET6, host.c_str(), &ipv6->sin6_addr) == 1) {
        ipv6->sin6_family = AF_INET6;
        out.size_bytes = sizeof *ipv6;
    } else {
        return std::nullopt;
    }
    out.set_port(port);
    return out;
}

std::string to_neighbourhood(const std::string& peer) {
    const std::string host = peer.substr(0, peer.rfind(':'));
    const bool in_brackets = host.size() > 2 && host.front() == '[' && host.back() == ']';
    const auto found =
        in_brackets ? numeric_endpoint(host.substr(1, host.size() - 2), 0) : std::nullopt;
    return found ? found->neighbourhood() : host;
}

std::vector<Endpoint> resolve(const Address& address, bool to_listen) {
    addrinfo wanted{};
    wanted.ai_family = AF_UNSPEC;
    wanted.ai_socktype = SOCK_STREAM;
    wanted.ai_flags = AI_NUMERICSERV | (to_listen ? AI_PASSIVE : 0);
    addrinfo* found = nullptr;
    const int code = ::getaddrinfo(address.host.empty() ? nullptr : address.host.c_str(),
                                   std::to_string(address.port).c_str(), &wanted, &found);
    if (code != 0)
        throw util::Error("look up " + (address.host.empty() ? address.text() : address.host) +
                          ": " +
                          (code == EAI_SYSTEM ? std::strerror(errno) : ::gai_strerror(code)));
    const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> owner(found, &::freeaddrinfo);
    std::vector<Endpoint> out;
    for (const addrinfo* one = found; one != nullptr; one = one->ai_next) {
        if (one->ai_family != AF_INET && one->ai_family != AF_INET6)
            continue;
        Endpoint endpoint;
        std::memcpy(&endpoint.storage, one->ai_addr, one->ai_addrlen);
        endpoint.size_bytes = one->ai_addrlen;
        out.push_back(endpoint);
    }
    if (out.empty())
        throw util::Error("look up " + address.host + ": it has no IPv4 or IPv6 address");
    return out;
}

std::vector<Socket> listen_at(const Address& address) {
    std::vector<Socket> out;
    if (address.host.empty()) {
        Endpoint any;
        auto* all = reinterpret_cast<sockaddr_in6*>(&any.storage);
        all->sin6_family = AF_INET6;
        all->sin6_addr = in6addr_any;
        any.size_bytes = sizeof *all;
        any.set_port(address.port);
        // IPv6 may be disabled on a machine: then IPv4 alone covers all interfaces.
        if (const Socket probe(::socket(AF_INET6, SOCK_STREAM | SOCK_CLOEXEC, 0)); probe) {
            out.push_back(listen_at(any, true, address.text()));
            return out;
        }
    }
    std::uint16_t port = address.port;
    for (Endpoint endpoint : resolve(address, true)) {
        endpoint.set_port(port);
        out.push_back(listen_at(endpoint, false, address.text()));
        port = bound_port(out.back().fd());
    }
    return out;
}

Socket connect_to(const Endpoint& endpoint, Deadline deadline) {
    const auto failed = [&](const std::string& why) {
        return util::Error("connect to " + endpoint.text() + ": " + why);
    };
    Socket socket(
        ::socket(endpoint.storage.ss_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    if (!socket)
        throw failed(std::strerror(errno));
    if (::connect(socket.fd(), endpoint.get(), endpoint.size_bytes) == 0)
        return socket;
    if (errno != EINPROGRESS)
        throw failed(std::strerror(errno));
    if (!wait_for(socket.fd(), POLLOUT, deadline))
        throw failed("no answer in time");
    int code = 0;
    socklen_t size = sizeof code;
    if (::getsockopt(socket.fd(), SOL_SOCKET, SO_ERROR, &code, &size) != 0)
        code = errno;
    if (code != 0)
        throw failed(std::strerror(code));
    return socket;
}

void tune(int fd, std::chrono::milliseconds lost_after) noexcept {
    // Each of these options improves the connection, and none is required: if the kernel lacks one,
    // that is not an error.
    const int on = 1;
    const int unsent_bytes = 256 << 10;
    const auto lost_after_ms = static_cast<unsigned>(lost_after.count());
    ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    ::setsockopt(fd, IPPROTO_TCP, TCP_NOTSENT_LOWAT, &unsent_bytes, sizeof unsent_bytes);
    ::setsockopt(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, &lost_after_ms, sizeof lost_after_ms);
}

void read_exactly(int fd, void* to, std::size_t size_bytes, Deadline deadline) {
    auto* at = static_cast<char*>(to);
    while (size_bytes > 0) {
        const ssize_t got = ::recv(fd, at, size_bytes, 0);
        if (got > 0) {
            at += got;
            size_bytes -= static_cast<std::size_t>(got);
        } else if (got == 0) {
            throw util::Error("it closed the connection");
        } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
            if (!wait_for(fd, POLLIN, deadline))
                throw util::Error("no answer in time");
        } else if (errno != EINTR) {
            throw util::Error(std::strerror(errno));
        }
    }
}

void write_all(int fd, const void* from, std::size_t size_bytes, Deadline deadline) {
    const auto* at = static_cast<const char*>(from);
    while (size_bytes > 0) {
        const ssize_t put = ::send(fd, at, size_bytes, MSG_NOSIGNAL);
        if (put >= 0) {
            at += put;
            size_bytes -= static_cast<std::size_t>(put);
        } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
            if (!wait_for(fd, POLLOUT, deadline))
                throw util::Error("no answer in time");
        } else if (errno != EINTR) {
            throw util::Error(std::strerror(errno));
        }
    }
}

}  // namespace terravox::sockets
