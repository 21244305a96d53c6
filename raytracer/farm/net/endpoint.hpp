#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "common/util/error.hpp"
#include "raytracer/farm/net/link.hpp"
#include "voxelserver/serve/sockets/socket.hpp"

namespace terravox::net {

inline constexpr std::uint16_t kWorkerPort = 7878;       ///< worker --listen, render --worker
inline constexpr std::uint16_t kCoordinatorPort = 7879;  ///< render --listen, worker --join

/// How both ends authenticate: either with a shared token, or with certificates of one CA on both
/// sides, which carry the DNS name "terravox-farm" (certificates.hpp makes these). With a token
/// nothing is encrypted: for trusted networks (handshake.hpp).
struct Credentials {
    std::string token;  ///< as util::check_token() wants it; empty with certificates
    std::filesystem::path ca, certificate, key;  ///< PEM; all three, or none
    [[nodiscard]] bool tls() const noexcept { return !ca.empty(); }
};

/// The peer is not authorised, or this program is not authorised there: trying again would not
/// help.
class RefusedError : public util::Error {
public:
    using util::Error::Error;
};

/// Connects and authenticates in both directions. Each address of a name is tried once; the
/// addresses share the timeout.
/// @throws UsageError for both kinds of credentials or none; RefusedError; Error when nothing
/// listens, there is no room, or no answer arrives in time
[[nodiscard]] std::unique_ptr<Link> dial(const sockets::Address& address,
                                         const Credentials& credentials,
                                         std::chrono::milliseconds timeout);

struct ListenerLimits {
    // At most a half (connections) and a quarter (handshakes) of the open files that the process
    // may have.
    int connections = 1024;            ///< admitted at once
    int connections_of_address = 256;  ///< from one address (of IPv6: its upper 64 bits)
    /// Connections that have not authenticated yet; when there are more, the oldest of the address
    /// with the most is closed.
    int handshakes = 256;
    std::chrono::milliseconds handshake{3000};  ///< time for the handshake
};

/// Accepts peers. Unauthorised ones are refused before a byte of theirs is parsed; each reason is
/// logged once a minute for each address.
class Listener {
public:
    /// Takes the link of an authenticated peer; called on a thread of that link's own, which ends
    /// when the call returns. The link lives as long as its owner keeps it and may be moved
    /// elsewhere.
    using OnLink = std::function<void(std::unique_ptr<Link>)>;
    /// @throws Error when it cannot listen there
    Listener(const sockets::Address& address, const Credentials& credentials, OnLink on_link,
             const ListenerLimits& limits = {});
    ~Listener();  ///< as stop()
    [[nodiscard]] std::uint16_t port() const noexcept;
    /// Accepts no new links and aborts existing ones; returns when all calls of on_link have ended.
    /// Must not be called from within one. Links that were closed before still deliver what they
    /// had sent.
    void stop() noexcept;

private:
    class Impl;
    std::unique_ptr<Impl> m_impl;
};

/// Logs why connections were refused: each reason once a minute for each address, so that a flood
/// does not fill the disk. Remembers at most kMaxKept of them; while it is full, others count
/// together as "other addresses", whatever their reasons. Not thread-safe.
class RefusalLog {
public:
    using Clock = std::chrono::steady_clock;
    static constexpr std::size_t kMaxKept = 1024;
    static constexpr std::chrono::seconds kQuiet{60};

    /// @param say receives the lines; none: they are logged as warnings
    /// @param what begins them
    explicit RefusalLog(std::function<void(const std::string&)> say = {},
                        std::string what = "farm: refused");
    /// @param who the address without its port
    /// @param peer the address with its port
    void refused(const std::string& who, const std::string& peer, const std::string& why,
                 Clock::time_point now = Clock::now());

private:
    struct Reported {
        Clock::time_point when;
        std::uint64_t since = 0;  ///< number of refusals that were not logged
    };
    std::function<void(const std::string&)> m_say;
    const std::string m_what;
    std::map<std::pair<std::string, std::string>, Reported> m_reported;
    /// When old entries were last removed; that is not done for each refusal, since there may be
    /// very many.
    Clock::time_point m_cleared{};
};

}  // namespace terravox::net
