#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>

#include "voxelserver/make/worlds/remote/address_range.hpp"

namespace terravox::remote {

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

/// An address as messages may show it: without user, query and fragment.
[[nodiscard]] std::string shown_url(const std::string& url);

/// The range of a host that is an IP address; nullopt: it is a name.
[[nodiscard]] std::optional<AddressRange> range_of_number(const HttpOrigin& origin);

/// The ranges of all addresses that the host currently resolves to; none for an unknown name.
/// Blocks for as long as the name service does, or until a stop is requested.
/// @throws Error when a stop is requested
[[nodiscard]] AddressRanges ranges_of_host(const HttpOrigin& origin,
                                           const std::stop_token& stop = {});

}  // namespace terravox::remote
