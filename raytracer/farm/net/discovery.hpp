#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/util/error.hpp"

namespace terravox::net {

/// What a program of the farm publishes about itself on the local network: short words by key
/// ("protocol", "software", "build", "role").
using ServiceText = std::map<std::string, std::string>;
inline constexpr const char* kServiceType = "_terravox._tcp";
inline constexpr std::size_t kMaxServiceText_bytes = 200;  ///< of a key and its value

/// A program of the farm that was found by multicast DNS. Any machine on the network may claim
/// anything there, so dialling the address still requires token or certificate. Texts are printable
/// (common/util/printable.hpp).
struct FoundService {
    std::string name;  ///< unique on the network; for display
    /// A numeric address, the best one known: IPv4, else IPv6; "fe80::1%eth0" where it is valid on
    /// one link alone.
    std::string address;
    std::uint16_t port = 0;
    ServiceText text;
    friend bool operator==(const FoundService&, const FoundService&) = default;
};

/// Thrown when there is no multicast DNS on this machine: no daemon, no system bus, or the program
/// was built without it.
class NoDiscoveryError : public util::Error {
public:
    using util::Error::Error;
};

/// Keeps a service published on all networks of this machine during its lifetime, for programs that
/// listen on all of them. Without Avahi it only logs one warning; when its daemon, or the system
/// bus, starts or returns later, the service is published then. Names that are taken get a number.
/// It has a thread of its own.
class Announcement {
public:
    /// @param role what others search for: "worker" or "coordinator"; stored in the text as `role`
    /// @param port 1 to 65535
    /// @throws Error for a text that is too long
    Announcement(const std::string& role, std::uint16_t port, const ServiceText& text);
    ~Announcement();  ///< withdraws the service
    Announcement(const Announcement&) = delete;
    Announcement& operator=(const Announcement&) = delete;
    /// The name under which the service is published; empty while it is not.
    [[nodiscard]] std::string name() const;

private:
    class Impl;
    std::unique_ptr<Impl> m_impl;
};

/// Reports services of a role that appear and disappear. When the daemon ends all services are
/// reported as gone, with a warning; when it is back, browsing starts anew.
class ServiceBrowser {
public:
    enum class Event {
        kFound,  ///< new, or a known name with another address, port or text
        kGone,   ///< no longer announced; connections to it may live on
    };
    /// Called on the browser's thread, one call after the other; must not destroy the browser.
    using OnEvent = std::function<void(Event, const FoundService&)>;
    /// @throws NoDiscoveryError when Avahi is not there
    ServiceBrowser(const std::string& role, OnEvent on_event);
    ~ServiceBrowser();  ///< no calls of OnEvent after this
    ServiceBrowser(const ServiceBrowser&) = delete;
    ServiceBrowser& operator=(const ServiceBrowser&) = delete;

    /// Waits until the services that exist now have been reported, as far as that can be known, but
    /// at most until the timeout; this takes about a second.
    void settle(std::chrono::milliseconds timeout);

private:
    class Impl;
    std::unique_ptr<Impl> m_impl;
};

/// Services of a role that exist now, by name.
/// @throws NoDiscoveryError when Avahi is not there
[[nodiscard]] std::vector<FoundService> discover(const std::string& role,
                                                 std::chrono::milliseconds timeout);

}  // namespace terravox::net
