#pragma once

#include <optional>
#include <string>
#include <vector>

#include "voxelserver/worlds/remote/address_range.hpp"
#include "voxelserver/worlds/remote/http_origin.hpp"

namespace terravox::remote {

/// A token that a person has bound to one origin: it is sent nowhere else.
class BoundToken {
public:
    /// @param text visible ASCII characters (util::find_server_token)
    /// @throws UsageError for http to any host but localhost and the numbers of loopback: it would
    /// go over the network in clear text
    BoundToken(HttpOrigin origin, std::string text);
    [[nodiscard]] const HttpOrigin& origin() const noexcept { return m_origin; }
    [[nodiscard]] const std::string& text() const noexcept { return m_text; }

private:
    HttpOrigin m_origin;
    std::string m_text;
};

/// Whom an HttpClient may ask, and what it shows there.
struct HttpAccess {
    /// Of a program that strangers tell addresses.
    struct Limits {
        std::vector<HttpOrigin> origins;  ///< where they lead to public numbers alone
        std::vector<HttpOrigin>
            private_origins;  ///< and where they may lead to private and loopback ones
    };
    std::optional<BoundToken> token;
    std::optional<Limits> limits;  ///< nullopt: a person names the addresses, any will do

    /// The numbers that a host may lead to; none: this origin may not be asked.
    [[nodiscard]] AddressRanges ranges(const HttpOrigin& origin) const;
    /// What may be asked instead of an origin, or a number, that may not: for messages.
    [[nodiscard]] const char* allowed() const noexcept;
};

/// Of a program that strangers tell addresses, and that no person has allowed any.
[[nodiscard]] inline HttpAccess access_to_nobody() {
    return {std::nullopt, HttpAccess::Limits{}};
}

/// For addresses that a person names: all of them, and the token of TERRAVOX_SERVER_TOKEN where
/// TERRAVOX_SERVER_ORIGIN binds it to one.
/// @throws UsageError for an origin without a token, or one that a token must not be bound to; as
/// util::find_server_token()
[[nodiscard]] HttpAccess access_of_environment();

}  // namespace terravox::remote
