#pragma once

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <thread>

#include "common/net/socket.hpp"
#include "tests/common/net/farm.hpp"

namespace terravox::test {

/// A wire to a listener that can be cut or go dead. Takes one connection.
class Wire {
public:
    explicit Wire(const net::Address& to)
        : m_listening(net::listen_at({.host = "127.0.0.1", .port = 0})), m_thread([this, to] { run(to); }) {}
    ~Wire() {
        m_state = State::kCut;
        m_thread.join();
    }
    [[nodiscard]] net::Address address() const {
        net::Endpoint bound;
        bound.size_bytes = sizeof bound.storage;
        ::getsockname(m_listening.front().fd(), reinterpret_cast<sockaddr*>(&bound.storage), &bound.size_bytes);
        return {.host = "127.0.0.1", .port = bound.port()};
    }
    void cut() { m_state = State::kCut; }    ///< both ends are reset, as by machines that crash and come back
    void stop() { m_state = State::kDead; }  ///< nothing goes through, and nobody is told, as when a cable is pulled out

private:
    enum class State { kWhole, kDead, kCut };
    void run(const net::Address& to) {
        net::Socket near;
        while (!near && m_state != State::kCut) {
            pollfd one{m_listening.front().fd(), POLLIN, 0};
            if (::poll(&one, 1, 5) > 0)
                near = net::Socket(::accept4(m_listening.front().fd(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
        }
        if (!near) return;
        net::Socket far = net::connect_to(net::resolve(to, false).front(), std::chrono::steady_clock::now() + kLong);
        bool open = true;
        while (open && m_state != State::kCut) {
            std::array<pollfd, 2> both{pollfd{near.fd(), POLLIN, 0}, pollfd{far.fd(), POLLIN, 0}};
            if (m_state == State::kDead) both[0].fd = both[1].fd = -1;
            if (::poll(both.data(), 2, 5) <= 0) continue;
            open = (both[0].revents == 0 || forward(near.fd(), far.fd())) && (both[1].revents == 0 || forward(far.fd(), near.fd()));
        }
        if (open) {
            const linger at_once{1, 0};
            for (const int fd : {near.fd(), far.fd()}) ::setsockopt(fd, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
        }
    }
    static bool forward(int from, int to) {
        std::array<char, 65536> bytes{};
        const ssize_t got = ::recv(from, bytes.data(), bytes.size(), 0);
        if (got <= 0) return false;
        try {
            net::write_all(to, bytes.data(), static_cast<std::size_t>(got), std::chrono::steady_clock::now() + kLong);
            return true;
        } catch (const Error&) {
            return false;
        }
    }

    std::vector<net::Socket> m_listening;
    std::atomic<State> m_state{State::kWhole};
    std::thread m_thread;
};

}  // namespace terravox::test
