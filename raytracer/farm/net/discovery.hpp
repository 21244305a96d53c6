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

/// What a program of the farm says of itself on the local network: short words by key ("protocol",
/// "software", "build", "role").
using ServiceText = std::map<std::string, std::string>;
inline constexpr const char* kServiceType = "_terravox._tcp";
inline constexpr std::size_t kMaxServiceText_bytes = 200;  ///< of a key and its value

/// A program of the farm that was found by multicast DNS. Anybody on the network may claim anything
/// there: who dials the address still asks for token or certificate. Texts are printable
/// (common/util/printable.hpp).
struct FoundService {
    std::string name;     ///< unique on the network; for people
    std::string address;  ///< a number, the best one known: IPv4, else IPv6; "fe80::1%eth0" where
                          ///< it holds on one link alone
    std::uint16_t port = 0;
    ServiceText text;
    friend bool operator==(const FoundService&, const FoundService&) = default;
};

/// There is no multicast DNS on this machine: no daemon, no system bus, or the program was built
/// without it.
class NoDiscoveryError : public util::Error {
public:
    using util::Error::Error;
};

/// Keeps a service published on all networks of this machine for as long as it lives: for who
/// listens on all of them. Where Avahi is not there, that is one warning in the log, and nothing
/// else; when its daemon comes or comes back later, the service is published then. Names that are
/// taken get a number. It has a thread of its own.
class Announcement {
public:
    /// @param role what others look for: "worker" or "coordinator"; goes into the text as `role`
    /// @param port 1 to 65535
    /// @throws Error for a text that is too long
    Announcement(const std::string& role, std::uint16_t port, const ServiceText& text);
    ~Announcement();  ///< takes the service back
    Announcement(const Announcement&) = delete;
    Announcement& operator=(const Announcement&) = delete;
    /// The name under which it stands on the network; empty while it does not.
    [[nodiscard]] std::string name() const;

private:
    class Impl;
    std::unique_ptr<Impl> m_impl;
};

/// Tells of services of a role that come and go. A daemon that ends takes all with it, with a
/// warning; when it is back, it begins anew.
class ServiceBrowser {
public:
    enum class Event {
        kFound,  ///< new, or under a name that is known with another address, port or text
        kGone,   ///< announced no more; connections to it may live on
    };
    /// Called on the browser's thread, one call after the other; must not destroy the browser.
    using OnEvent = std::function<void(Event, const FoundService&)>;
    /// @throws NoDiscoveryError when Avahi is not there
    ServiceBrowser(const std::string& role, OnEvent on_event);
    ~ServiceBrowser();  ///< no call after it
    ServiceBrowser(const ServiceBrowser&) = delete;
    ServiceBrowser& operator=(const ServiceBrowser&) = delete;

    /// Waits until those have been told that are there now, as far as one may know, but no longer
    /// than this; that takes about a second.
    void settle(std::chrono::milliseconds timeout);

private:
    class Impl;
    std::unique_ptr<Impl> m_impl;
};

/// Services of a role that are there now, by name. @throws NoDiscoveryError when Avahi is not there
[[nodiscard]] std::vector<FoundService> discover(const std::string& role,
                                                 std::chrono::milliseconds timeout);

}  // namespace terravox::net
