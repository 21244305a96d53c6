#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "common/util/error.hpp"
#include "raytracer/farm/net/link.hpp"
#include "voxelserver/sockets/address.hpp"

namespace terravox::net {

inline constexpr std::uint16_t kWorkerPort = 7878;       ///< worker --listen, render --worker
inline constexpr std::uint16_t kCoordinatorPort = 7879;  ///< render --listen, worker --join

/// How both ends show that they may. Either a shared token, or certificates of one CA on both
/// sides, which carry the DNS name "terravox-farm" (certs.hpp makes such). With a token nothing is
/// encrypted: for networks that are trusted (handshake.hpp).
struct Credentials {
    std::string token;  ///< at least 16 characters; empty with certificates
    std::filesystem::path ca, certificate, key;  ///< PEM; all three, or none
    [[nodiscard]] bool tls() const noexcept { return !ca.empty(); }
};

/// The peer may not, or we may not there: trying again would not help.
class RefusedError : public util::Error {
public:
    using util::Error::Error;
};

/// Connects, and shows and asks for the credentials. Each address of a name is tried once, and
/// shares the timeout with the others.
/// @throws UsageError for both kinds of credentials or none; RefusedError; Error when nobody
/// listens, there is no room, or nobody answers in time
[[nodiscard]] std::unique_ptr<Link> dial(const sockets::Address& address,
                                         const Credentials& credentials,
                                         std::chrono::milliseconds timeout);

struct ListenerLimits {
    // No more than a half (connections) and a quarter (handshakes) of the open files that the
    // process may have.
    int connections = 1024;            ///< admitted at once
    int connections_of_address = 256;  ///< from one address (of IPv6: its upper 64 bits)
    int handshakes = 256;  ///< that have not shown yet that they may; the oldest of the address
                           ///< with the most goes when there are more
    std::chrono::milliseconds handshake{3000};  ///< time for it
};

/// Waits for peers. PendingPeers are refused before a byte of theirs is parsed; each reason is
/// logged once a minute for each address.
class Listener {
public:
    /// Takes a link whose peer has shown that it may; called on a thread of that link's own, which
    /// ends when the call returns. The link lives as long as its owner keeps it: it may be moved
    /// elsewhere.
    using OnLink = std::function<void(std::unique_ptr<Link>)>;
    /// @throws Error when it cannot listen there
    Listener(const sockets::Address& address, const Credentials& credentials, OnLink on_link,
             const ListenerLimits& limits = {});
    ~Listener();  ///< as stop()
    [[nodiscard]] std::uint16_t port() const noexcept;
    /// No new links; those that are there are aborted; returns when all calls of on_link have
    /// ended. Not from within one. Links that were closed before still deliver what they had sent.
    void stop() noexcept;

private:
    class Impl;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace terravox::net
