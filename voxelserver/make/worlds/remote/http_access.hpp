#pragma once

#include <sys/socket.h>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

namespace terravox::remote {

/// The range that an IP address belongs to.
enum class AddressRange : std::uint8_t {
    kPublic,    ///< any machine of the Internet
    kPrivate,   ///< a local network: private, link-local, shared by a carrier's customers
    kLoopback,  ///< this machine
    /// Unspecified, multicast, reserved, for documentation, or IPv4 embedded in IPv6.
    kNoMachine,
};

/// A set of address ranges.
class AddressRanges {
public:
    constexpr AddressRanges(std::initializer_list<AddressRange> ranges = {}) noexcept {
        for (const AddressRange range : ranges)
            add(range);
    }
    constexpr void add(AddressRange range) noexcept {
        m_bits |= 1U << static_cast<unsigned>(range);
    }
    [[nodiscard]] constexpr bool holds(AddressRange range) const noexcept {
        return (m_bits >> static_cast<unsigned>(range) & 1U) != 0;
    }
    [[nodiscard]] constexpr bool empty() const noexcept { return m_bits == 0; }
    [[nodiscard]] constexpr AddressRanges operator&(const AddressRanges& other) const noexcept {
        AddressRanges out;
        out.m_bits = m_bits & other.m_bits;
        return out;
    }
    friend bool operator==(const AddressRanges&, const AddressRanges&) = default;

private:
    unsigned m_bits = 0;
};
inline constexpr AddressRanges kAnyRange{AddressRange::kPublic, AddressRange::kPrivate,
                                         AddressRange::kLoopback, AddressRange::kNoMachine};

/// @param address of IPv4 or IPv6; of anything else: kNoMachine
[[nodiscard]] AddressRange make_range(const sockaddr& address) noexcept;

/// "127.0.0.1", "::1".
[[nodiscard]] std::string to_text(const sockaddr& address);

/// Scheme, host and port of an address, which a secret or a permission is bound to. Two addresses
/// that differ only in their path have the same origin.
/// Ref: Barth, "The Web Origin Concept", RFC 6454, 2011.
struct HttpOrigin {
    bool tls = false;
    std::string host;  ///< in lower case; an IPv6 address in brackets
    std::uint16_t port = 0;

    /// The origin of the address of a world, as libcurl parses it.
    /// @param url http(s)://host[:port][/path], up to 2048 bytes
    /// @throws UsageError for anything else, such as a user, a query or a fragment: those may be
    /// secret, and a path appended to the address would become part of them
    [[nodiscard]] static HttpOrigin of(const std::string& url);
    /// @param text http(s)://host[:port]
    /// @throws UsageError for anything else
    [[nodiscard]] static HttpOrigin parse(const std::string& text);

    [[nodiscard]] std::string text() const;  ///< "https://voxels.example:443"
    friend bool operator==(const HttpOrigin&, const HttpOrigin&) = default;
};

/// The origin of the address that a server redirects to. It may have a query, such as a signature,
/// since nothing is appended to it.
/// @param attempt begins the message, which does not show the query
/// @throws Error for anything but http and https, for a user, and for http after https
[[nodiscard]] HttpOrigin redirect_target(const std::string& attempt, const HttpOrigin& from,
                                         const std::string& location);

/// An address as messages may show it: without user, query and fragment.
[[nodiscard]] std::string shown_url(const std::string& url);

/// The range of a host that is an IP address; nullopt: it is a name.
[[nodiscard]] std::optional<AddressRange> range_of_number(const HttpOrigin& origin);

/// The ranges of all addresses that the host currently resolves to; none for an unknown name.
/// Blocks for as long as the name service does, or until a stop is requested.
/// @throws Error when a stop is requested
[[nodiscard]] AddressRanges ranges_of_host(const HttpOrigin& origin,
                                           const std::stop_token& stop = {});

/// A token that the user has bound to one origin: it is sent nowhere else.
class BoundToken {
public:
    /// @param text visible ASCII characters (util::check_token)
    /// @throws UsageError for http to any host but localhost and loopback addresses: the token
    /// would cross the network in clear text
    BoundToken(HttpOrigin origin, std::string text);
    [[nodiscard]] const HttpOrigin& origin() const noexcept { return m_origin; }
    [[nodiscard]] const std::string& text() const noexcept { return m_text; }

private:
    HttpOrigin m_origin;
    std::string m_text;
};

/// The origins that an HttpClient may contact, and the token that it sends there.
struct HttpAccess {
    /// For a program that receives addresses from untrusted clients.
    struct Limits {
        std::vector<HttpOrigin> origins;  ///< allowed where they resolve to public addresses only
        /// Allowed to resolve to private and loopback addresses, too.
        std::vector<HttpOrigin> private_origins;
    };
    std::optional<BoundToken> token;
    std::optional<Limits> limits;  ///< nullopt: the user names the addresses, all are allowed

    /// The address ranges that a host may resolve to; none: this origin may not be contacted.
    [[nodiscard]] AddressRanges ranges(const HttpOrigin& origin) const;
    /// The same for a host that a server redirects to, not a user.
    /// @param from the range of the machine that answered with the redirect: without limits, none
    /// that the user may not have meant is contacted, as one of the local network by a public one,
    /// or by one whose address is not known
    [[nodiscard]] AddressRanges ranges(const HttpOrigin& origin, AddressRange from) const;
    /// Describes what is allowed instead of a refused origin or address: for messages.
    [[nodiscard]] const char* allowed() const noexcept;
};

/// For a program that receives addresses from untrusted clients, with no allowed origin.
[[nodiscard]] inline HttpAccess no_http_access() {
    return {std::nullopt, HttpAccess::Limits{}};
}

/// For addresses that the user names: all are allowed, and the token of TERRAVOX_SERVER_TOKEN is
/// sent where TERRAVOX_SERVER_ORIGIN binds it to one.
/// @throws UsageError for an origin without a token, or one that a token must not be bound to; as
/// util::find_token()
[[nodiscard]] HttpAccess access_of_environment();

}  // namespace terravox::remote
