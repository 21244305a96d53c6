#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <string>

#include "raytracer/farm/net/endpoint.hpp"
#include "tests/eventually.hpp"

namespace terravox::test {

/// No test measures time: this is what ends one that hangs.
inline constexpr std::chrono::seconds kLong = kHangs;
inline constexpr const char* kToken = "token-of-the-tests-7f3a9c51e8b2d604";

/// What a listener hands over, for the thread of the test. The calls of on_link return at once:
/// links live on.
class Arrivals {
public:
    [[nodiscard]] net::Listener::OnLink taker() {
        return [this](std::unique_ptr<net::Link> link) {
            const std::lock_guard lock(m_mutex);
            m_links.push_back(std::move(link));
            m_arrived.notify_all();
        };
    }
    /// @return nothing when none arrives
    [[nodiscard]] std::unique_ptr<net::Link> next(std::chrono::milliseconds timeout = kLong) {
        std::unique_lock lock(m_mutex);
        if (!m_arrived.wait_for(lock, timeout, [&] { return !m_links.empty(); }))
            return nullptr;
        auto link = std::move(m_links.front());
        m_links.pop_front();
        return link;
    }

private:
    std::mutex m_mutex;
    std::condition_variable m_arrived;
    std::deque<std::unique_ptr<net::Link>> m_links;
};

/// A listener on a free port of this machine, and a way to it.
class Farm {
public:
    explicit Farm(
        net::Credentials credentials = {.token = kToken, .ca = {}, .certificate = {}, .key = {}},
        net::ListenerLimits limits = {})
        : m_credentials(std::move(credentials)),
          m_listener({.host = "127.0.0.1", .port = 0}, m_credentials, m_arrivals.taker(), limits) {}
    [[nodiscard]] sockets::Address address() const {
        return {.host = "127.0.0.1", .port = m_listener.port()};
    }
    [[nodiscard]] std::unique_ptr<net::Link> dial() const {
        return net::dial(address(), m_credentials, kLong);
    }
    struct Pair {
        std::unique_ptr<net::Link> dialled, accepted;
    };
    [[nodiscard]] Pair pair() {
        Pair out;
        out.dialled = dial();
        out.accepted = m_arrivals.next();
        return out;
    }
    /// Whether a peer is admitted, and a frame arrives. On a busy machine it may need more time
    /// than a test's limits leave it: then again.
    [[nodiscard]] bool works() {
        const auto deadline = std::chrono::steady_clock::now() + kLong;
        while (std::chrono::steady_clock::now() < deadline) {
            try {
                const auto dialled = dial();
                farm::Frame frame;
                frame.mutable_ping()->set_stamp(5);
                if (!dialled->send(frame))
                    continue;
                // One that was given up may have arrived before.
                while (const auto accepted = m_arrivals.next())
                    if (const auto got = accepted->receive())
                        return got->ping().stamp() == 5;
                return false;
            } catch (const net::RefusedError&) {
                return false;
            } catch (const util::Error&) {
            }
        }
        return false;
    }
    [[nodiscard]] Arrivals& arrivals() noexcept { return m_arrivals; }
    [[nodiscard]] net::Listener& listener() noexcept { return m_listener; }
    [[nodiscard]] const net::Credentials& credentials() const noexcept { return m_credentials; }

private:
    Arrivals m_arrivals;
    net::Credentials m_credentials;
    net::Listener m_listener;
};

[[nodiscard]] inline farm::Frame ping(std::uint64_t stamp) {
    farm::Frame frame;
    frame.mutable_ping()->set_stamp(stamp);
    return frame;
}
/// @param size_bytes of its content; the frame is a few bytes larger
[[nodiscard]] inline farm::Frame done(std::uint64_t id, std::size_t size_bytes) {
    farm::Frame frame;
    frame.mutable_done()->set_id(id);
    frame.mutable_done()->set_result(std::string(size_bytes, static_cast<char>('a' + id % 26)));
    return frame;
}

}  // namespace terravox::test
