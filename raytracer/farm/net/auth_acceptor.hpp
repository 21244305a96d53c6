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

#include "raytracer/farm/net/endpoint.hpp"
#include "raytracer/farm/net/handshake.hpp"
#include "voxelserver/serve/sockets/socket.hpp"

namespace terravox::net {

/// Accepts connections, and admits those whose peers authenticate: by the handshake of the token;
/// or, where certificates are required, those that begin TLS, whose certificates are then checked
/// by the receiver of the connection. It never exceeds its limits.
///
/// A single thread of its own does all the work and never blocks on a single peer. PendingPeers
/// (connections that have not authenticated yet) have a time limit from the moment of connection,
/// so that slow ones gain nothing. When there are too many, or the process has no descriptors left,
/// the oldest of the address with the most connections is closed. A spare descriptor is kept for
/// the case that there are no pending peers to close: with it a connection is accepted and closed,
/// as it would otherwise stay in the kernel's queue and keep this loop busy.
///
/// An admitted peer is *expected* until joined() reports that its call has arrived, and has a time
/// limit for that, too. Meanwhile a second descriptor of its connection is kept here to detect its
/// end, and to end it. The mutex guards only the admitted peers, for which joined() and left() are
/// called from other threads; descriptors are closed only by the loop, which may have them in its
/// poll().
class AuthAcceptor {
public:
    /// Takes the connection of an admitted peer; called on the acceptor's thread.
    using Admit = std::function<void(sockets::Socket, const std::string& peer)>;
    /// @throws Error when it cannot listen there
    AuthAcceptor(const sockets::Address& address, const Credentials& credentials,
                 const ListenerLimits& limits, Admit admit);
    ~AuthAcceptor() { stop(); }  ///< as stop()
    void start();                ///< begins to admit peers; call once

    [[nodiscard]] std::uint16_t port() const noexcept { return m_port; }
    void stop() noexcept;  ///< stops listening
    /// Reports that the call of an admitted peer has arrived.
    /// @return its number; nullopt: no peer of that name is expected, or its call has arrived
    /// before
    [[nodiscard]] std::optional<std::uint64_t> joined(const std::string& peer);
    /// Reports that the call has ended.
    /// @param number distinguishes the peer from a later connection from the same port
    void left(const std::string& peer, std::uint64_t number);
    /// Logs a refusal of a peer for which joined() returned a number.
    void log_refusal(const std::string& peer, const std::string& why);

private:
    using Clock = std::chrono::steady_clock;
    enum class Phase { kFirstByte, kToken, kLeaving };
    struct PendingPeer {
        sockets::Socket socket;
        std::string peer;
        std::string address;
        Clock::time_point connected_at;
        Clock::time_point deadline;
        Phase phase = Phase::kToken;
        ListenerHandshake handshake;
        bool has_sent = false;
    };
    struct AdmittedPeer {
        std::uint64_t number = 0;
        std::string address;
        Clock::time_point connected_at;
        Clock::time_point deadline;
        sockets::Socket end_watch;  ///< none once it was closed
        bool joined = false;
        bool ended = false;
    };
    using PendingPeers = std::list<PendingPeer>;

    void run() noexcept;
    void round();
    void accept_from(int listening);
    void add_pending(sockets::Socket socket, const sockets::Endpoint& from);
    void read_from(PendingPeers::iterator pending);
    void first_byte(PendingPeers::iterator pending);
    void token_bytes(PendingPeers::iterator pending);
    void admit(PendingPeers::iterator pending);
    bool send(PendingPeers::iterator pending, const Bytes& bytes);
    void reject(PendingPeers::iterator pending, const Bytes& reply, const std::string& why);
    void refuse(PendingPeers::iterator pending, const std::string& why);
    void overdue(Clock::time_point now);
    void check_admitted(Clock::time_point now);
    bool make_room(const char* why);
    std::size_t unauthenticated_count() const;
    void wake() noexcept;
    /// Pauses briefly, where continuing at once would only keep a core busy.
    void back_off() noexcept;

    const Credentials m_credentials;
    ListenerLimits m_limits;
    const Admit m_admit;
    std::vector<sockets::Socket> m_listening;
    std::uint16_t m_port = 0;
    sockets::Socket m_spare;
    sockets::Socket m_wake;
    PendingPeers m_pending;
    mutable std::mutex m_mutex;
    std::map<std::string, AdmittedPeer> m_admitted;  ///< by peer
    std::uint64_t m_numbers = 0;
    std::mutex m_log_mutex;
    RefusalLog m_log;
    std::atomic<bool> m_stopping{false};
    std::thread m_thread;
};

}  // namespace terravox::net
