#pragma once

#include <atomic>
#include <functional>
#include <list>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "raytracer/farm/net/farm_port.hpp"
#include "raytracer/farm/net/handshake.hpp"
#include "raytracer/farm/net/refusal_log.hpp"
#include "voxelserver/sockets/socket.hpp"

namespace terravox::net {

/// Accepts connections, and lets those in whose peers show that they may: by the handshake of the
/// token; or, where certificates are wanted, those that begin TLS, whose certificates are then
/// looked at by whom they are handed to. Never more than the limits allow.
///
/// One thread of its own does all of it and never waits for a single peer. Strangers (connections
/// that have shown nothing yet) have a time limit from their first moment on, so that slow ones
/// gain nothing; when there are too many, or the process has no descriptors left, the oldest of the
/// address with the most goes. A spare descriptor is kept for the case that there are no strangers
/// to close: with it a connection is taken and closed, as it would otherwise stay in the queue of
/// the kernel and keep this loop busy.
///
/// A guest was let in; it is *expected* until joined() says that its call has come, and has a time
/// limit for that, too. Meanwhile a second descriptor of its connection is kept here to see it end,
/// and to end it. The mutex guards the guests alone, which joined() and left() are told about from
/// other threads; descriptors are closed by the loop only, which may have them in its poll().
class Doorkeeper {
public:
    /// Takes the connection of a guest; called on the thread of the doorkeeper.
    using Admit = std::function<void(Socket, const std::string& peer)>;
    /// @throws Error when it cannot listen there
    Doorkeeper(const Address& address, const Credentials& credentials, const ListenerLimits& limits,
               Admit admit);
    ~Doorkeeper();  ///< as stop()
    void start();   ///< from now on it lets in; once
    Doorkeeper(const Doorkeeper&) = delete;
    Doorkeeper& operator=(const Doorkeeper&) = delete;

    [[nodiscard]] std::uint16_t port() const noexcept { return m_port; }
    void stop() noexcept;  ///< listens no more
    /// The call of a guest has come. @return its number; nullopt: nobody is expected by that name,
    /// or its call has come before
    [[nodiscard]] std::optional<std::uint64_t> joined(const std::string& peer);
    /// @param number  a port may be another connection's by now
    void left(const std::string& peer, std::uint64_t number);
    void tell_refusal(const std::string& peer,
                      const std::string& why);  ///< of one that joined() was true for

private:
    using Clock = std::chrono::steady_clock;
    enum class Phase { kFirstByte, kToken, kLeaving };
    struct Stranger {
        Socket socket;
        std::string peer, address;
        Clock::time_point came, deadline;
        Phase phase = Phase::kToken;
        ListenerHandshake handshake;
        bool said_something = false;
    };
    struct Guest {
        std::uint64_t number = 0;
        std::string address;
        Clock::time_point came, deadline;
        Socket witness;  ///< none once it was closed
        bool joined = false, gone = false;
    };
    using Strangers = std::list<Stranger>;

    void run() noexcept;
    void round();
    void accept_from(int listening);
    void take_in(Socket socket, const Endpoint& from);
    void hear(Strangers::iterator stranger);
    void first_byte(Strangers::iterator stranger);
    void token_bytes(Strangers::iterator stranger);
    void let_in(Strangers::iterator stranger);
    bool send(Strangers::iterator stranger, const Bytes& bytes);
    void leave(Strangers::iterator stranger, const Bytes& reply, const std::string& why);
    void refuse(Strangers::iterator stranger, const std::string& why);
    void overdue(Clock::time_point now);
    void see_guests(Clock::time_point now);
    bool make_room(const char* why);
    std::size_t unproven() const;
    void wake() noexcept;
    void rest() noexcept;  ///< for a moment, where going on at once would only keep a core busy

    const Credentials m_credentials;
    ListenerLimits m_limits;
    const Admit m_admit;
    std::vector<Socket> m_listening;
    std::uint16_t m_port = 0;
    Socket m_spare, m_wake;
    Strangers m_strangers;
    mutable std::mutex m_mutex;
    std::map<std::string, Guest> m_guests;  ///< by peer
    std::uint64_t m_numbers = 0;
    std::mutex m_log_mutex;
    RefusalLog m_log;
    std::atomic<bool> m_stopping{false};
    std::thread m_thread;
};

}  // namespace terravox::net
