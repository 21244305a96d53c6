#pragma once

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <thread>

#include "tests/raytracer/farm/net/raw_peer.hpp"
#include "voxelserver/serve/sockets/socket.hpp"

namespace terravox::test {

/// A wire to a listener that can be slow, be cut or go dead. Takes one connection.
class Wire {
public:
    explicit Wire(const sockets::Address& to)
        : m_listening(sockets::listen_at({.host = "127.0.0.1", .port = 0})) {
        // What a wire holds by itself is not on its way yet: little, set where it listens, as the
        // window is agreed upon at the beginning.
        const int held_bytes = 64 << 10;
        ::setsockopt(m_listening.front().fd(), SOL_SOCKET, SO_RCVBUF, &held_bytes,
                     sizeof held_bytes);
        m_thread = std::thread([this, to] { run(to); });
    }
    ~Wire() {
        m_state = State::kCut;
        m_thread.join();
    }
    [[nodiscard]] sockets::Address address() const { return bound_address(m_listening.front()); }
    /// Resets both ends, as by machines that crash and restart.
    void cut() { m_state = State::kCut; }
    /// Transfers nothing more, and closes nothing, as when a cable is pulled out.
    void stop() { m_state = State::kDead; }
    /// Limits the rate from the dialler to the listener; 0: no limit.
    void slow(std::size_t bytes_per_s) { m_bytes_per_s = bytes_per_s; }

private:
    enum class State { kWhole, kDead, kCut };
    void run(const sockets::Address& to) {
        sockets::Socket near;
        while (!near && m_state != State::kCut) {
            pollfd one{m_listening.front().fd(), POLLIN, 0};
            if (::poll(&one, 1, 5) > 0)
                near = sockets::Socket(::accept4(m_listening.front().fd(), nullptr, nullptr,
                                                 SOCK_NONBLOCK | SOCK_CLOEXEC));
        }
        if (!near)
            return;
        sockets::Socket far = sockets::connect_to(sockets::resolve(to, false).front(),
                                                  std::chrono::steady_clock::now() + kLong);
        bool open = true;
        auto free_at =
            std::chrono::steady_clock::now();  // the slow direction carries nothing before that
        while (open && m_state != State::kCut) {
            std::array<pollfd, 2> both{pollfd{near.fd(), POLLIN, 0}, pollfd{far.fd(), POLLIN, 0}};
            if (m_state == State::kDead)
                both[0].fd = both[1].fd = -1;
            const auto now = std::chrono::steady_clock::now();
            if (now < free_at)
                both[0].fd = -1;
            if (::poll(both.data(), 2, 5) <= 0)
                continue;
            std::size_t there_bytes = 0, back_bytes = 0;
            open = (both[0].revents == 0 || forward(near.fd(), far.fd(), there_bytes)) &&
                   (both[1].revents == 0 || forward(far.fd(), near.fd(), back_bytes));
            if (const std::size_t rate = m_bytes_per_s; rate > 0)
                free_at = std::max(free_at, now) +
                          std::chrono::microseconds(there_bytes * 1'000'000 / rate);
        }
        if (open) {
            const linger at_once{1, 0};
            for (const int fd : {near.fd(), far.fd()})
                ::setsockopt(fd, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
        }
    }
    static bool forward(int from, int to, std::size_t& carried_bytes) {
        std::array<char, 16384> bytes{};
        const ssize_t got = ::recv(from, bytes.data(), bytes.size(), 0);
        if (got <= 0)
            return false;
        carried_bytes = static_cast<std::size_t>(got);
        try {
            sockets::write_all(to, bytes.data(), static_cast<std::size_t>(got),
                               std::chrono::steady_clock::now() + kLong);
            return true;
        } catch (const util::Error&) {
            return false;
        }
    }

    std::vector<sockets::Socket> m_listening;
    std::atomic<State> m_state{State::kWhole};
    std::atomic<std::size_t> m_bytes_per_s{0};
    std::thread m_thread;
};

}  // namespace terravox::test
