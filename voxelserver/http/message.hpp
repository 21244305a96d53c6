#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace terravox::http {

struct Header {
    std::string_view name, value;
};

/// What a client asked. Views are valid while the request is handled.
struct Request {
    std::string_view method, path;  ///< path: as sent, not decoded, without the query
    std::vector<Header> headers;
    std::string_view query = {};  ///< as sent, not decoded, without the question mark
    std::string_view body = {};   ///< read whole, where the route takes one

    /// Values of all headers of that name (any case), in the order sent, joined by ", "; empty when
    /// there is none.
    [[nodiscard]] std::string header(std::string_view name) const;
    [[nodiscard]] bool has_header(std::string_view name) const noexcept;
};

/// Sends a part of a body. @return false when the client is gone: further parts are of no use
using Write = std::function<bool(std::string_view)>;

/// A reply. Content-Length, Date and Connection are left to the server that sends it.
struct Response {
    int status = 200;
    std::string head;  ///< header lines, each with its end; add() writes them
    std::shared_ptr<const std::string> body;  ///< nullptr: none
    std::string_view fixed_body = {};  ///< instead of body: bytes that live as long as the program
    std::function<void(const Write&)>
        stream;  ///< instead of body: called once to send one of a length not known before
    bool head_only =
        false;           ///< reply to HEAD: the length of the body is told, the body is not sent
    bool close = false;  ///< the connection must not be used again

    /// Control characters are left out: they would end the header. @return this
    Response& add(std::string_view name, std::string_view value);
    /// @return the header's value, or "" when there is none
    [[nodiscard]] std::string header(std::string_view name) const;
    [[nodiscard]] std::string_view bytes() const noexcept {
        return body ? std::string_view(*body) : fixed_body;
    }
};

[[nodiscard]] bool same_word(std::string_view a, std::string_view b) noexcept;  ///< ASCII, any case
[[nodiscard]] std::string_view reason_phrase(int status) noexcept;

/// An error's text without the folders of this machine: of each absolute path only the name at its
/// end stays. Where it is not plain what belongs to a path (blanks in it), rather more goes than
/// too little.
[[nodiscard]] std::string without_folders(std::string_view text);

[[nodiscard]] Response reply(int status, std::string_view content_type, std::string body);
/// application/problem+json. Ref: Nottingham & Wilde, RFC 7807, 2016.
[[nodiscard]] Response problem(int status, const std::string& detail);

/// Does If-None-Match name this entity tag (quotes included)? Weak comparison. Ref: Fielding et
/// al., RFC 9110, 13.1.2.
[[nodiscard]] bool etag_matches(std::string_view if_none_match, std::string_view etag) noexcept;

/// How a body may be sent. Ref: RFC 9110, 12.5.3.
enum class Coding { kIdentity, kZstd, kNone };  ///< kNone: the client takes neither
/// @param accept_encoding the header's value; "": the client says nothing, and gets identity
[[nodiscard]] Coding choose_coding(std::string_view accept_encoding) noexcept;

/// What the headers say of a request's body.
struct BodyClaim {
    enum class Kind { kNone, kSome, kMalformed } kind = Kind::kNone;
    std::uint64_t bytes = 0;  ///< of kSome
};
[[nodiscard]] BodyClaim body_claim(const Request& request);

}  // namespace terravox::http
