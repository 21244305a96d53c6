#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>

#include "voxelserver/worlds/remote/address_range.hpp"

namespace terravox::remote {

/// Scheme, host and port of an address: what a secret or a permission is bound to. Two addresses
/// that differ in nothing but path have one. Ref: Barth, "The Web Origin Concept", RFC 6454, 2011.
struct HttpOrigin {
    bool tls = false;
    std::string host;  ///< in lower case; an IPv6 number in brackets
    std::uint16_t port = 0;

    /// Of the address of a world, as libcurl reads it.
    /// @param url http(s)://host[:port][/path], up to 2048 bytes
    /// @throws UsageError for anything else, such as a user, a query or a fragment: those may be
    /// secret, and would take what is appended
    [[nodiscard]] static HttpOrigin of(const std::string& url);
    /// @param text http(s)://host[:port] @throws UsageError for anything else
    [[nodiscard]] static HttpOrigin parse(const std::string& text);

    [[nodiscard]] std::string text() const;  ///< "https://voxels.example:443"
    friend bool operator==(const HttpOrigin&, const HttpOrigin&) = default;
};

/// An address as messages may show it: without user, query and fragment.
[[nodiscard]] std::string shown_url(const std::string& url);

/// Where the host leads when it is a number; nullopt: it is a name.
[[nodiscard]] std::optional<AddressRange> range_of_number(const HttpOrigin& origin);

/// Where the host leads: all that the name service knows of it, now; none for a name that it does
/// not know. Blocks for as long as that service does, or until it is asked to stop.
/// @throws Error when it is asked to stop
[[nodiscard]] AddressRanges ranges_of_host(const HttpOrigin& origin,
                                           const std::stop_token& stop = {});

}  // namespace terravox::remote
