#pragma once

#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <span>
#include <string>

#include "raytracer/farm/net/endpoint.hpp"
#include "tests/raytracer/farm/net/farm.hpp"
#include "voxelserver/serve/sockets/socket.hpp"

namespace terravox::test {

/// @return where a socket listens on this machine
[[nodiscard]] inline sockets::Address bound_address(const sockets::Socket& listening) {
    sockets::Endpoint bound;
    bound.size_bytes = sizeof bound.storage;
    ::getsockname(listening.fd(), reinterpret_cast<sockaddr*>(&bound.storage), &bound.size_bytes);
    return {.host = "127.0.0.1", .port = bound.port()};
}

/// A connection that sends arbitrary bytes.
class RawPeer {
public:
    explicit RawPeer(const sockets::Address& address)
        : m_socket(sockets::connect_to(sockets::resolve(address, false).front(),
                                       std::chrono::steady_clock::now() + kLong)) {}
    explicit RawPeer(sockets::Socket socket) : m_socket(std::move(socket)) {}
    /// @return false: the other end has closed
    bool say(std::span<const std::byte> bytes) {
        try {
            sockets::write_all(m_socket.fd(), bytes.data(), bytes.size(),
                               std::chrono::steady_clock::now() + kLong);
            return true;
        } catch (const util::Error&) {
            return false;
        }
    }
    bool say(const std::string& text) { return say(std::as_bytes(std::span(text))); }
    /// All bytes until the other end closes.
    std::string hear_all() {
        std::string out;
        const auto deadline = std::chrono::steady_clock::now() + kLong;
        for (char c = 0;;) {
            try {
                sockets::read_exactly(m_socket.fd(), &c, 1, deadline);
            } catch (const util::Error& e) {
                return std::string(e.what()).find("in time") == std::string::npos ? out
                                                                                  : "(still open)";
            }
            out += c;
        }
    }
    [[nodiscard]] sockets::Socket& socket() noexcept { return m_socket; }

private:
    sockets::Socket m_socket;
};

}  // namespace terravox::test
