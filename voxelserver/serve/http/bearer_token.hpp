#pragma once

#include <string>

#include "voxelserver/serve/http/message.hpp"

namespace terravox::http {

/// The token that clients send as "Authorization: Bearer TOKEN". Immutable, thread-safe.
/// Ref: Jones & Hardt, RFC 6750, 2012.
class BearerToken {
public:
    /// @param secret "": the server requires no token, and no request has a valid one
    explicit BearerToken(std::string secret = "") : m_secret(std::move(secret)) {}

    [[nodiscard]] bool is_required() const noexcept { return !m_secret.empty(); }

    /// Whether the request has the token. The comparison takes constant time, independent of the
    /// number of matching characters.
    [[nodiscard]] bool is_in(const Request& request) const;

private:
    const std::string m_secret;
};

}  // namespace terravox::http
