#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "voxelserver/serve/http/message.hpp"

namespace terravox::http {

/// The origins whose web pages may read what routes share with them (RouteFacts::shared): none by
/// default. Immutable, thread-safe. Ref: Fetch Standard, 3.2 (CORS protocol).
///
/// Preflight requests are not answered: a page sends none for GET with a single Range, but for
/// If-Match and for a token. So pages of other origins read without both.
class SharedOrigins {
public:
    SharedOrigins() = default;
    /// @param origins "https://example.org", "http://localhost:8080"; "*" alone: any
    /// @throws UsageError for anything else, such as one with a path
    explicit SharedOrigins(std::vector<std::string> origins);

    /// @param origin value of the header Origin
    [[nodiscard]] bool allow(std::string_view origin) const noexcept;
    /// Lets the page that has sent the request read the reply; nothing where it is not allowed.
    void add_headers(const Request& request, Response& reply) const;

private:
    [[nodiscard]] bool is_any() const noexcept;

    std::vector<std::string> m_origins;
};

}  // namespace terravox::http
