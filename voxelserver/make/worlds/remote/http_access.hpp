#pragma once

#include <optional>
#include <string>
#include <vector>

#include "voxelserver/make/worlds/remote/address_range.hpp"
#include "voxelserver/make/worlds/remote/http_origin.hpp"

namespace terravox::remote {

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
