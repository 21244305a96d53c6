#include "raytracer/farm/net/auth_acceptor.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "common/thread/start_threads.hpp"
#include "common/util/log.hpp"

namespace terravox::net {
namespace {

constexpr int kAcceptsOfRound = 64;
constexpr std::chrono::seconds kGrace{1};  ///< to close in order, after a refusal that was sent
constexpr std::chrono::seconds kLostAfter{15};  ///< for a peer that acknowledges no data
constexpr std::byte kTlsHandshake{0x16};
constexpr const char* kTooMany = "too many unauthenticated connections at once";
constexpr const char* kNoDescriptors = "the limit of open files is reached";

/// A share of the descriptors that the process may have: other parts need some, too.
int share_of_descriptors(int wanted, rlim_t part) {
    rlimit limit{};
    if (::getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY)
        return wanted;
    return static_cast<int>(
        std::clamp<rlim_t>(limit.rlim_cur / part, 1, static_cast<rlim_t>(std::max(wanted, 1))));
}

sockets::Socket spare_descriptor() {
    return sockets::Socket(::open("/dev/null", O_RDONLY | O_CLOEXEC));
}

/// "handshake_failure", fatal: what a dialler with certificates understands.
Bytes tls_alert() {
    Bytes out;
    for (const int byte : {0x15, 0x03, 0x01, 0x00, 0x02, 0x02, 0x28})
        out.push_back(static_cast<std::byte>(byte));
    return out;
}

bool out_of_descriptors(int code) {
    return code == EMFILE || code == ENFILE;
}

}  // namespace

AuthAcceptor::AuthAcceptor(const sockets::Address& address, const Credentials& credentials,
                           const ListenerLimits& limits, Admit admit)
    : m_credentials(credentials),
      m_limits(limits),
      m_admit(std::move(admit)),
      m_listening(sockets::listen_at(address)),
      m_spare(spare_descriptor()),
      m_wake(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
    if (!m_wake)
        throw util::Error("listen at " + address.text() + ": " + std::strerror(errno));
    m_limits.handshakes = share_of_descriptors(limits.handshakes, 4);
    m_limits.connections = share_of_descriptors(limits.connections, 2);
    if (m_limits.connections < limits.connections || m_limits.handshakes < limits.handshakes)
        util::log_info(
            "farm: the limit of open files allows {} connections and {} unauthenticated ones at "
            "once, not {} "
            "and {}",
            m_limits.connections, m_limits.handshakes, limits.connections, limits.handshakes);
    sockets::Endpoint bound;
    bound.size_bytes = sizeof bound.storage;
    if (::getsockname(m_listening.front().fd(), reinterpret_cast<sockaddr*>(&bound.storage),
                      &bound.size_bytes) != 0)
        throw util::Error("listen at " + address.text() + ": " + std::strerror(errno));
    m_port = bound.port();
}

void AuthAcceptor::start() {
    m_thread = thread::start_thread("connections that come in", [this] { run(); });
}

void AuthAcceptor::stop() noexcept {
    m_stopping = true;
    wake();
    if (m_thread.joinable())
        m_thread.join();
    m_listening.clear();
    m_pending.clear();
}

void AuthAcceptor::wake() noexcept {
    const std::uint64_t one = 1;
    // It fails only when many wake-ups are pending already.
    [[maybe_unused]] const ssize_t put = ::write(m_wake.fd(), &one, sizeof one);
}

std::optional<std::uint64_t> AuthAcceptor::joined(const std::string& peer) {
    std::uint64_t number = 0;
    {
        const std::lock_guard lock(m_mutex);
        const auto admitted = m_admitted.find(peer);
        if (admitted == m_admitted.end() || admitted->second.joined || admitted->second.ended)
            return std::nullopt;
        admitted->second.joined = true;
        number = admitted->second.number;
    }
    wake();
    return number;
}

void AuthAcceptor::left(const std::string& peer, std::uint64_t number) {
    {
        const std::lock_guard lock(m_mutex);
        if (const auto admitted = m_admitted.find(peer);
            admitted != m_admitted.end() && admitted->second.number == number)
            admitted->second.ended = true;
    }
    wake();
}

void AuthAcceptor::log_refusal(const std::string& peer, const std::string& why) {
    std::string address = peer;
    {
        const std::lock_guard lock(m_mutex);
        if (const auto admitted = m_admitted.find(peer); admitted != m_admitted.end())
            address = admitted->second.address;
    }
    const std::lock_guard lock(m_log_mutex);
    m_log.refused(address, peer, why);
}

void AuthAcceptor::run() noexcept {
    while (!m_stopping) {
        try {
            round();
        } catch (const std::exception& e) {
            // The work of one round is lost, at most one connection. Memory may be short, so it
            // pauses before trying again.
            util::log_error("farm: accept connections: {}", e.what());
            back_off();
        }
    }
}

void AuthAcceptor::back_off() noexcept {
    pollfd wake_only{m_wake.fd(), POLLIN, 0};
    ::poll(&wake_only, 1, 50);
}

void AuthAcceptor::round() {
    std::vector<pollfd> polled;
    polled.push_back({m_wake.fd(), POLLIN, 0});
    for (const auto& socket : m_listening)
        polled.push_back({socket.fd(), POLLIN, 0});
    std::vector<PendingPeers::iterator> pending_peers;
    auto next = Clock::now() + std::chrono::hours(1);
    for (auto one = m_pending.begin(); one != m_pending.end(); ++one) {
        pending_peers.push_back(one);
        polled.push_back({one->socket.fd(), POLLIN, 0});
        next = std::min(next, one->deadline);
    }
    std::vector<std::string> admitted_peers;
    {
        const std::lock_guard lock(m_mutex);
        for (const auto& [peer, admitted] : m_admitted) {
            if (!admitted.end_watch)
                continue;
            admitted_peers.push_back(peer);
            polled.push_back({admitted.end_watch.fd(), 0, 0});  // only to detect its end
            next = std::min(next, admitted.deadline);
        }
    }
    const auto wait_ms = std::chrono::ceil<std::chrono::milliseconds>(next - Clock::now()).count();
    const int ready = ::poll(polled.data(), polled.size(),
                             static_cast<int>(std::clamp<long long>(wait_ms, 0, 60'000)));
    if (ready < 0 && errno != EINTR)
        throw util::Error(std::string("poll: ") + std::strerror(errno));
    if (m_stopping)
        return;

    if ((polled.front().revents & POLLIN) != 0) {
        std::uint64_t count = 0;
        [[maybe_unused]] const ssize_t got = ::read(m_wake.fd(), &count, sizeof count);
    }
    const std::size_t first_pending = 1 + m_listening.size();
    const std::size_t first_admitted = first_pending + pending_peers.size();
    for (std::size_t i = 0; ready > 0 && i < pending_peers.size(); ++i)
        if (polled[first_pending + i].revents != 0)
            read_from(pending_peers[i]);
    {
        const std::lock_guard lock(m_mutex);
        for (std::size_t i = 0; ready > 0 && i < admitted_peers.size(); ++i) {
            const auto admitted = m_admitted.find(admitted_peers[i]);
            if (admitted != m_admitted.end() &&
                (polled[first_admitted + i].revents & (POLLHUP | POLLERR)) != 0)
                admitted->second.deadline = Clock::time_point::min();
        }
    }
    overdue(Clock::now());
    check_admitted(Clock::now());
    for (std::size_t i = 0; ready > 0 && i < m_listening.size(); ++i)
        if ((polled[1 + i].revents & POLLIN) != 0)
            accept_from(m_listening[i].fd());
}

void AuthAcceptor::accept_from(int listening) {
    for (int i = 0; i < kAcceptsOfRound; ++i) {
        sockets::Endpoint from;
        from.size_bytes = sizeof from.storage;
        sockets::Socket socket(::accept4(listening, reinterpret_cast<sockaddr*>(&from.storage),
                                         &from.size_bytes, SOCK_NONBLOCK | SOCK_CLOEXEC));
        if (socket) {
            add_pending(std::move(socket), from);
        } else if (out_of_descriptors(errno)) {
            if (make_room(kNoDescriptors))
                continue;
            m_spare.close();
            sockets::Socket unlucky(::accept4(listening, nullptr, nullptr, SOCK_CLOEXEC));
            const bool drained = static_cast<bool>(unlucky) || !out_of_descriptors(errno);
            unlucky.close();
            m_spare = spare_descriptor();
            {
                const std::lock_guard lock(m_log_mutex);
                m_log.refused("", "connections", kNoDescriptors);
            }
            if (!drained)
                return back_off();
        } else if (errno != EINTR && errno != ECONNABORTED) {
            const int code = errno;
            if (code != EAGAIN && code != EWOULDBLOCK) {
                const std::lock_guard lock(m_log_mutex);
                m_log.refused("", "connections", std::strerror(code));
            }
            // The connection stays in the kernel's queue.
            if (code == ENOBUFS || code == ENOMEM)
                back_off();
            return;
        }
    }
}

void AuthAcceptor::add_pending(sockets::Socket socket, const sockets::Endpoint& from) {
    while (unauthenticated_count() >= static_cast<std::size_t>(m_limits.handshakes) &&
           make_room(kTooMany)) {
    }
    if (!m_spare)
        m_spare = spare_descriptor();
    const auto now = Clock::now();
    m_pending.push_back({.socket = std::move(socket),
                         .peer = from.text(),
                         .address = from.neighbourhood(),
                         .connected_at = now,
                         .deadline = now + m_limits.handshake,
                         .phase = m_credentials.tls() ? Phase::kFirstByte : Phase::kToken,
                         .handshake = ListenerHandshake(m_credentials.token)});
}

std::size_t AuthAcceptor::unauthenticated_count() const {
    const std::lock_guard lock(m_mutex);
    return m_pending.size() + static_cast<std::size_t>(std::count_if(
                                  m_admitted.begin(), m_admitted.end(), [](const auto& one) {
                                      return static_cast<bool>(one.second.end_watch);
                                  }));
}

bool AuthAcceptor::make_room(const char* why) {
    std::map<std::string, int> of_address;
    std::string worst;
    const auto count = [&](const std::string& address) {
        if (++of_address[address] > of_address[worst] || worst.empty())
            worst = address;
    };
    for (const auto& one : m_pending)
        count(one.address);
    {
        const std::lock_guard lock(m_mutex);
        for (const auto& [peer, admitted] : m_admitted)
            if (admitted.end_watch && !admitted.joined)
                count(admitted.address);
    }
    if (of_address.empty())
        return false;
    // The list is in the order of connection.
    const auto oldest = std::find_if(m_pending.begin(), m_pending.end(),
                                     [&](const PendingPeer& one) { return one.address == worst; });
    if (oldest != m_pending.end()) {
        refuse(oldest, why);
        return true;
    }
    std::string peer;
    {
        const std::lock_guard lock(m_mutex);
        auto longest = m_admitted.end();
        for (auto one = m_admitted.begin(); one != m_admitted.end(); ++one)
            if (one->second.address == worst && one->second.end_watch && !one->second.joined &&
                (longest == m_admitted.end() ||
                 one->second.connected_at < longest->second.connected_at))
                longest = one;
        if (longest == m_admitted.end())
            return false;
        peer = longest->first;
        ::shutdown(longest->second.end_watch.fd(), SHUT_RDWR);
        m_admitted.erase(longest);
    }
    const std::lock_guard lock(m_log_mutex);
    m_log.refused(worst, peer, why);
    return true;
}

void AuthAcceptor::read_from(PendingPeers::iterator pending) {
    switch (pending->phase) {
        case Phase::kFirstByte: return first_byte(pending);
        case Phase::kToken: return token_bytes(pending);
        case Phase::kLeaving: break;
    }
    std::array<std::byte, 512> ignored{};
    for (int i = 0; i < 8; ++i) {
        const ssize_t got = ::recv(pending->socket.fd(), ignored.data(), ignored.size(), 0);
        if (got > 0)
            continue;
        if (got == 0 || (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR))
            m_pending.erase(pending);
        return;
    }
}

void AuthAcceptor::first_byte(PendingPeers::iterator pending) {
    std::byte first{};
    const ssize_t got = ::recv(pending->socket.fd(), &first, 1, MSG_PEEK);
    if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR))
        return;
    if (got <= 0)
        return refuse(pending, "it closed the connection without sending anything");
    pending->has_sent = true;
    if (first == kTlsHandshake)
        return admit(pending);
    // token_bytes() answers a peer that has a token that it is not accepted, and refuses all
    // others.
    pending->phase = Phase::kToken;
    token_bytes(pending);
}

void AuthAcceptor::token_bytes(PendingPeers::iterator pending) {
    using Outcome = ListenerHandshake::Outcome;
    std::array<std::byte, kHello_bytes> bytes{};
    for (;;) {
        const ssize_t got = ::recv(pending->socket.fd(), bytes.data(),
                                   std::min(bytes.size(), pending->handshake.wanted()), 0);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK))
            return;
        if (got <= 0)
            return refuse(pending, pending->has_sent
                                       ? "it closed the connection in the handshake"
                                       : "it closed the connection without sending anything");
        const bool tls_hello =
            pending->handshake.wanted() == kHello_bytes && bytes[0] == kTlsHandshake;
        pending->has_sent = true;
        const auto step =
            pending->handshake.take(std::span(bytes).first(static_cast<std::size_t>(got)));
        switch (step.outcome) {
            case Outcome::kMore:
                if (!send(pending, step.reply))
                    return refuse(pending, "it does not read the answer");
                break;
            case Outcome::kAnotherVersion:
                return reject(pending, step.reply,
                              "it uses handshake version " +
                                  std::to_string(pending->handshake.version_of_peer()) +
                                  "; allowed: " + std::to_string(kHandshakeVersion));
            case Outcome::kNotTerravox:
                if (tls_hello && !m_credentials.tls())
                    return reject(pending, tls_alert(), "it begins TLS; a token is required here");
                return refuse(pending, "it is no peer of a Terravox farm");
            case Outcome::kWrongToken:
                if (m_credentials.tls())
                    return reject(pending, pending->handshake.answer(Verdict::kCertificates),
                                  "it has a token; certificates are required here");
                return reject(pending, pending->handshake.answer(Verdict::kWrongToken),
                              "wrong token");
            case Outcome::kProven: return admit(pending);
        }
    }
}

/// The peer has proven the token, or begins TLS.
void AuthAcceptor::admit(PendingPeers::iterator pending) {
    const bool tls = m_credentials.tls();
    std::string busy;
    {
        const std::lock_guard lock(m_mutex);
        const auto here = m_admitted.size();
        const auto of_address =
            std::count_if(m_admitted.begin(), m_admitted.end(),
                          [&](const auto& one) { return one.second.address == pending->address; });
        if (here >= static_cast<std::size_t>(m_limits.connections))
            busy = "no room for more than " + std::to_string(m_limits.connections) + " connections";
        if (of_address >= m_limits.connections_of_address)
            busy = "no room for more than " + std::to_string(m_limits.connections_of_address) +
                   " connections of one address";
    }
    sockets::Socket end_watch(busy.empty() ? ::fcntl(pending->socket.fd(), F_DUPFD_CLOEXEC, 0)
                                           : -1);
    if (busy.empty() && !end_watch)
        busy = std::strerror(errno);
    if (!busy.empty())
        return tls ? refuse(pending, busy)
                   : reject(pending, pending->handshake.answer(Verdict::kBusy), busy);
    if (!tls && !send(pending, pending->handshake.answer(Verdict::kWelcome)))
        return refuse(pending, "it does not read the answer");
    sockets::Socket socket = std::move(pending->socket);
    const std::string peer = pending->peer;
    const auto now = Clock::now();
    {
        const std::lock_guard lock(m_mutex);
        // gRPC's own handshake deadline comes first: then the reason is the certificate, as far as
        // can be determined here.
        m_admitted[peer] = {.number = ++m_numbers,
                            .address = pending->address,
                            .connected_at = pending->connected_at,
                            .deadline = now + m_limits.handshake + kGrace,
                            .end_watch = std::move(end_watch)};
    }
    m_pending.erase(pending);
    sockets::tune(socket.fd(), kLostAfter);
    m_admit(std::move(socket), peer);
}

bool AuthAcceptor::send(PendingPeers::iterator pending, const Bytes& bytes) {
    // Nothing else was sent before, and so few bytes fit into any socket buffer.
    return bytes.empty() ||
           ::send(pending->socket.fd(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT) ==
               static_cast<ssize_t>(bytes.size());
}

/// Leaves time for the peer to receive the answer: closing at once, with unread bytes of the peer,
/// would discard it.
void AuthAcceptor::reject(PendingPeers::iterator pending, const Bytes& reply,
                          const std::string& why) {
    if (!send(pending, reply) || ::shutdown(pending->socket.fd(), SHUT_WR) != 0)
        return refuse(pending, why);
    {
        const std::lock_guard lock(m_log_mutex);
        m_log.refused(pending->address, pending->peer, why);
    }
    pending->phase = Phase::kLeaving;
    pending->deadline = Clock::now() + kGrace;
}

void AuthAcceptor::refuse(PendingPeers::iterator pending, const std::string& why) {
    if (pending->phase != Phase::kLeaving) {
        const std::lock_guard lock(m_log_mutex);
        m_log.refused(pending->address, pending->peer, why);
    }
    m_pending.erase(pending);
}

void AuthAcceptor::overdue(Clock::time_point now) {
    for (auto one = m_pending.begin(); one != m_pending.end();) {
        const auto pending = one++;
        if (now >= pending->deadline)
            refuse(pending, pending->has_sent
                                ? "it is too slow in the handshake"
                                : "it sent nothing within " +
                                      std::to_string(m_limits.handshake.count()) + " ms");
    }
}

void AuthAcceptor::check_admitted(Clock::time_point now) {
    std::vector<std::pair<std::string, std::string>> refused;  // address, peer
    {
        const std::lock_guard lock(m_mutex);
        for (auto one = m_admitted.begin(); one != m_admitted.end();) {
            auto& [peer, admitted] = *one;
            if (admitted.joined)
                admitted.end_watch.close();
            if (!admitted.joined && !admitted.ended && now >= admitted.deadline) {
                refused.emplace_back(admitted.address, peer);
                ::shutdown(admitted.end_watch.fd(), SHUT_RDWR);
                admitted.ended = true;
            }
            one = admitted.ended ? m_admitted.erase(one) : std::next(one);
        }
    }
    const std::lock_guard lock(m_log_mutex);
    for (const auto& [address, peer] : refused)
        m_log.refused(address, peer,
                      m_credentials.tls() ? "it showed no certificate of this farm"
                                          : "it sent nothing after the handshake");
}

}  // namespace terravox::net
