#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace terravox::http {

struct Header {
    std::string name, value;
};

/// What a client asked. Views are valid while the request is handled.
struct Request {
    std::string_view method, path;  ///< path: as sent, not decoded, without the query
    std::vector<Header> headers;

    /// Values of all headers of that name (any case), in the order sent, joined by ", "; empty when there is none.
    [[nodiscard]] std::string header(std::string_view name) const;
    [[nodiscard]] bool has_header(std::string_view name) const noexcept;
};

/// A whole reply. Content-Length, Date and Connection are left to the server that sends it.
struct Response {
    int status = 200;
    std::vector<Header> headers;
    std::shared_ptr<const std::string> body;  ///< nullptr: none
    bool head_only = false;                   ///< reply to HEAD: the length of the body is told, the body is not sent
    bool close = false;                       ///< the connection must not be used again

    [[nodiscard]] const std::string* header(std::string_view name) const noexcept;
    [[nodiscard]] std::size_t content_length() const noexcept { return body ? body->size() : 0; }
};

[[nodiscard]] bool same_word(std::string_view a, std::string_view b) noexcept;  ///< ASCII, any case
[[nodiscard]] std::string_view reason_phrase(int status) noexcept;

[[nodiscard]] Response reply(int status, std::string content_type, std::string body);
/// application/problem+json. Ref: Nottingham & Wilde, RFC 7807, 2016.
[[nodiscard]] Response problem(int status, const std::string& detail);

/// Does If-None-Match name this entity tag (quotes included)? Weak comparison. Ref: Fielding et al., RFC 9110, 13.1.2.
[[nodiscard]] bool etag_matches(std::string_view if_none_match, std::string_view etag) noexcept;

/// What the headers say of a request's body.
enum class BodyClaim { kNone, kSome, kMalformed };
[[nodiscard]] BodyClaim body_claim(const Request& request);

}  // namespace terravox::http
