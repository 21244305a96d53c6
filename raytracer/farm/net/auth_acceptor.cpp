#include "raytracer/farm/net/auth_acceptor.hpp"

#include <fcntl.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "common/thread/start_threads.hpp"

namespace terravox::net {
namespace {

constexpr int kAcceptsOfRound = 64;
constexpr std::chrono::seconds kGrace{1};  ///< to close in order, after a refusal that was sent
constexpr std::chrono::seconds kLostAfter{15};  ///< for a peer that acknowledges no data
constexpr std::byte kTlsHandshake{0x16};
constexpr const char* kTooMany = "too many strangers at once";
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
        spdlog::info(
            "farm: the limit of open files allows {} connections and {} strangers at once, not {} "
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

AuthAcceptor::~AuthAcceptor() {
    stop();
}

void AuthAcceptor::stop() noexcept {
    m_stopping = true;
    wake();
    if (m_thread.joinable())
        m_thread.join();
    m_listening.clear();
    m_strangers.clear();
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
        const auto guest = m_guests.find(peer);
        if (guest == m_guests.end() || guest->second.joined || guest->second.gone)
            return std::nullopt;
        guest->second.joined = true;
        number = guest->second.number;
    }
    wake();
    return number;
}

void AuthAcceptor::left(const std::string& peer, std::uint64_t number) {
    {
        const std::lock_guard lock(m_mutex);
        if (const auto guest = m_guests.find(peer);
            guest != m_guests.end() && guest->second.number == number)
            guest->second.gone = true;
    }
    wake();
}

void AuthAcceptor::log_refusal(const std::string& peer, const std::string& why) {
    std::string address = peer;
    {
        const std::lock_guard lock(m_mutex);
        if (const auto guest = m_guests.find(peer); guest != m_guests.end())
            address = guest->second.address;
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
            spdlog::error("farm: accept connections: {}", e.what());
            rest();
        }
    }
}

void AuthAcceptor::rest() noexcept {
    pollfd wake_only{m_wake.fd(), POLLIN, 0};
    ::poll(&wake_only, 1, 50);
}

void AuthAcceptor::round() {
    std::vector<pollfd> polled;
    polled.push_back({m_wake.fd(), POLLIN, 0});
    for (const auto& socket : m_listening)
        polled.push_back({socket.fd(), POLLIN, 0});
    std::vector<PendingPeers::iterator> strangers;
    auto next = Clock::now() + std::chrono::hours(1);
    for (auto one = m_strangers.begin(); one != m_strangers.end(); ++one) {
        strangers.push_back(one);
        polled.push_back({one->socket.fd(), POLLIN, 0});
        next = std::min(next, one->deadline);
    }
    std::vector<std::string> guests;
    {
        const std::lock_guard lock(m_mutex);
        for (const auto& [peer, guest] : m_guests) {
            if (!guest.witness)
                continue;
            guests.push_back(peer);
            polled.push_back({guest.witness.fd(), 0, 0});  // only to detect its end
            next = std::min(next, guest.deadline);
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
    const std::size_t first_stranger = 1 + m_listening.size(),
                      first_guest = first_stranger + strangers.size();
    for (std::size_t i = 0; ready > 0 && i < strangers.size(); ++i)
        if (polled[first_stranger + i].revents != 0)
            hear(strangers[i]);
    {
        const std::lock_guard lock(m_mutex);
        for (std::size_t i = 0; ready > 0 && i < guests.size(); ++i) {
            const auto guest = m_guests.find(guests[i]);
            if (guest != m_guests.end() &&
                (polled[first_guest + i].revents & (POLLHUP | POLLERR)) != 0)
                guest->second.deadline = Clock::time_point::min();
        }
    }
    overdue(Clock::now());
    see_guests(Clock::now());
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
            take_in(std::move(socket), from);
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
                return rest();
        } else if (errno != EINTR && errno != ECONNABORTED) {
            const int code = errno;
            if (code != EAGAIN && code != EWOULDBLOCK) {
                const std::lock_guard lock(m_log_mutex);
                m_log.refused("", "connections", std::strerror(code));
            }
            // The connection stays in the kernel's queue.
            if (code == ENOBUFS || code == ENOMEM)
                rest();
            return;
        }
    }
}

void AuthAcceptor::take_in(sockets::Socket socket, const sockets::Endpoint& from) {
    while (unproven() >= static_cast<std::size_t>(m_limits.handshakes) && make_room(kTooMany)) {
    }
    if (!m_spare)
        m_spare = spare_descriptor();
    const auto now = Clock::now();
    m_strangers.push_back({.socket = std::move(socket),
                           .peer = from.text(),
                           .address = from.neighbourhood(),
                           .came = now,
                           .deadline = now + m_limits.handshake,
                           .phase = m_credentials.tls() ? Phase::kFirstByte : Phase::kToken,
                           .handshake = ListenerHandshake(m_credentials.token)});
}

std::size_t AuthAcceptor::unproven() const {
    const std::lock_guard lock(m_mutex);
    return m_strangers.size() + static_cast<std::size_t>(std::count_if(
                                    m_guests.begin(), m_guests.end(), [](const auto& one) {
                                        return static_cast<bool>(one.second.witness);
                                    }));
}

bool AuthAcceptor::make_room(const char* why) {
    std::map<std::string, int> of_address;
    std::string worst;
    const auto count = [&](const std::string& address) {
        if (++of_address[address] > of_address[worst] || worst.empty())
            worst = address;
    };
    for (const auto& one : m_strangers)
        count(one.address);
    {
        const std::lock_guard lock(m_mutex);
        for (const auto& [peer, guest] : m_guests)
            if (guest.witness && !guest.joined)
                count(guest.address);
    }
    if (of_address.empty())
        return false;
    // They came in the order of the list.
    const auto oldest = std::find_if(m_strangers.begin(), m_strangers.end(),
                                     [&](const PendingPeer& one) { return one.address == worst; });
    if (oldest != m_strangers.end()) {
        refuse(oldest, why);
        return true;
    }
    std::string peer;
    {
        const std::lock_guard lock(m_mutex);
        auto longest = m_guests.end();
        for (auto one = m_guests.begin(); one != m_guests.end(); ++one)
            if (one->second.address == worst && one->second.witness && !one->second.joined &&
                (longest == m_guests.end() || one->second.came < longest->second.came))
                longest = one;
        if (longest == m_guests.end())
            return false;
        peer = longest->first;
        ::shutdown(longest->second.witness.fd(), SHUT_RDWR);
        m_guests.erase(longest);
    }
    const std::lock_guard lock(m_log_mutex);
    m_log.refused(worst, peer, why);
    return true;
}

void AuthAcceptor::hear(PendingPeers::iterator stranger) {
    switch (stranger->phase) {
        case Phase::kFirstByte: return first_byte(stranger);
        case Phase::kToken: return token_bytes(stranger);
        case Phase::kLeaving: break;
    }
    std::array<std::byte, 512> ignored{};
    for (int i = 0; i < 8; ++i) {
        const ssize_t got = ::recv(stranger->socket.fd(), ignored.data(), ignored.size(), 0);
        if (got > 0)
            continue;
        if (got == 0 || (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR))
            m_strangers.erase(stranger);
        return;
    }
}

void AuthAcceptor::first_byte(PendingPeers::iterator stranger) {
    std::byte first{};
    const ssize_t got = ::recv(stranger->socket.fd(), &first, 1, MSG_PEEK);
    if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR))
        return;
    if (got <= 0)
        return refuse(stranger, "it closed the connection without a word");
    stranger->said_something = true;
    if (first == kTlsHandshake)
        return let_in(stranger);
    // token_bytes() answers a peer that has a token that it is not accepted, and refuses all
    // others.
    stranger->phase = Phase::kToken;
    token_bytes(stranger);
}

void AuthAcceptor::token_bytes(PendingPeers::iterator stranger) {
    using Outcome = ListenerHandshake::Outcome;
    std::array<std::byte, kHello_bytes> bytes{};
    for (;;) {
        const ssize_t got = ::recv(stranger->socket.fd(), bytes.data(),
                                   std::min(bytes.size(), stranger->handshake.wanted()), 0);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK))
            return;
        if (got <= 0)
            return refuse(stranger, stranger->said_something
                                        ? "it closed the connection in the handshake"
                                        : "it closed the connection without a word");
        const bool tls_hello =
            stranger->handshake.wanted() == kHello_bytes && bytes[0] == kTlsHandshake;
        stranger->said_something = true;
        const auto step =
            stranger->handshake.take(std::span(bytes).first(static_cast<std::size_t>(got)));
        switch (step.outcome) {
            case Outcome::kMore:
                if (!send(stranger, step.reply))
                    return refuse(stranger, "it takes no answer");
                break;
            case Outcome::kAnotherVersion:
                return leave(stranger, step.reply,
                             "it shakes hands by version " +
                                 std::to_string(stranger->handshake.version_of_peer()) +
                                 ", this end by " + std::to_string(kHandshakeVersion));
            case Outcome::kNotTerravox:
                if (tls_hello && !m_credentials.tls())
                    return leave(stranger, tls_alert(), "it speaks TLS; a token is wanted here");
                return refuse(stranger, "it is no peer of a Terravox farm");
            case Outcome::kWrongToken:
                if (m_credentials.tls())
                    return leave(stranger, stranger->handshake.answer(Verdict::kCertificates),
                                 "it comes with a token; certificates are wanted here");
                return leave(stranger, stranger->handshake.answer(Verdict::kWrongToken),
                             "wrong token");
            case Outcome::kProven: return let_in(stranger);
        }
    }
}

/// The peer has proven the token, or begins TLS.
void AuthAcceptor::let_in(PendingPeers::iterator stranger) {
    const bool tls = m_credentials.tls();
    std::string busy;
    {
        const std::lock_guard lock(m_mutex);
        const auto here = m_guests.size();
        const auto of_address =
            std::count_if(m_guests.begin(), m_guests.end(),
                          [&](const auto& one) { return one.second.address == stranger->address; });
        if (here >= static_cast<std::size_t>(m_limits.connections))
            busy = "no room for more than " + std::to_string(m_limits.connections) + " connections";
        if (of_address >= m_limits.connections_of_address)
            busy = "no room for more than " + std::to_string(m_limits.connections_of_address) +
                   " connections of one address";
    }
    sockets::Socket witness(busy.empty() ? ::fcntl(stranger->socket.fd(), F_DUPFD_CLOEXEC, 0) : -1);
    if (busy.empty() && !witness)
        busy = std::strerror(errno);
    if (!busy.empty())
        return tls ? refuse(stranger, busy)
                   : leave(stranger, stranger->handshake.answer(Verdict::kBusy), busy);
    if (!tls && !send(stranger, stranger->handshake.answer(Verdict::kWelcome)))
        return refuse(stranger, "it takes no answer");
    sockets::Socket socket = std::move(stranger->socket);
    const std::string peer = stranger->peer;
    const auto now = Clock::now();
    {
        const std::lock_guard lock(m_mutex);
        // gRPC's own handshake deadline comes first: then the reason is the certificate, as far as
        // can be determined here.
        m_guests[peer] = {.number = ++m_numbers,
                          .address = stranger->address,
                          .came = stranger->came,
                          .deadline = now + m_limits.handshake + kGrace,
                          .witness = std::move(witness)};
    }
    m_strangers.erase(stranger);
    sockets::tune(socket.fd(), kLostAfter);
    m_admit(std::move(socket), peer);
}

bool AuthAcceptor::send(PendingPeers::iterator stranger, const Bytes& bytes) {
    // Nothing else was sent before, and so few bytes fit into any socket buffer.
    return bytes.empty() ||
           ::send(stranger->socket.fd(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT) ==
               static_cast<ssize_t>(bytes.size());
}

/// Leaves time for the peer to receive the answer: closing at once, with unread bytes of the peer,
/// would discard it.
void AuthAcceptor::leave(PendingPeers::iterator stranger, const Bytes& reply,
                         const std::string& why) {
    if (!send(stranger, reply) || ::shutdown(stranger->socket.fd(), SHUT_WR) != 0)
        return refuse(stranger, why);
    {
        const std::lock_guard lock(m_log_mutex);
        m_log.refused(stranger->address, stranger->peer, why);
    }
    stranger->phase = Phase::kLeaving;
    stranger->deadline = Clock::now() + kGrace;
}

void AuthAcceptor::refuse(PendingPeers::iterator stranger, const std::string& why) {
    if (stranger->phase != Phase::kLeaving) {
        const std::lock_guard lock(m_log_mutex);
        m_log.refused(stranger->address, stranger->peer, why);
    }
    m_strangers.erase(stranger);
}

void AuthAcceptor::overdue(Clock::time_point now) {
    for (auto one = m_strangers.begin(); one != m_strangers.end();) {
        const auto stranger = one++;
        if (now >= stranger->deadline)
            refuse(stranger, stranger->said_something
                                 ? "it is too slow in the handshake"
                                 : "it said nothing within " +
                                       std::to_string(m_limits.handshake.count()) + " ms");
    }
}

void AuthAcceptor::see_guests(Clock::time_point now) {
    std::vector<std::pair<std::string, std::string>> refused;  // address, peer
    {
        const std::lock_guard lock(m_mutex);
        for (auto one = m_guests.begin(); one != m_guests.end();) {
            auto& [peer, guest] = *one;
            if (guest.joined)
                guest.witness.close();
            if (!guest.joined && !guest.gone && now >= guest.deadline) {
                refused.emplace_back(guest.address, peer);
                ::shutdown(guest.witness.fd(), SHUT_RDWR);
                guest.gone = true;
            }
            one = guest.gone ? m_guests.erase(one) : std::next(one);
        }
    }
    const std::lock_guard lock(m_log_mutex);
    for (const auto& [address, peer] : refused)
        m_log.refused(address, peer,
                      m_credentials.tls() ? "it showed no certificate of this farm"
                                          : "it said nothing after the handshake");
}

}  // namespace terravox::net
