#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace terravox::http {

struct Header {
    std::string_view name;
    std::string_view value;
};

/// A request of a client. The views are valid while the request is handled.
struct Request {
    std::string_view method, path;  ///< path: as sent, not decoded, without the query
    std::vector<Header> headers;
    std::string_view query = {};    ///< as sent, not decoded, without the question mark
    std::string_view body = {};     ///< complete, for routes that accept one
    std::string_view client = {};   ///< numeric address; "": of this process
    std::string_view version = {};  ///< of HTTP, "1.0" or "1.1"; "": of this process

    /// Values of all headers of that name (case-insensitive), in the order sent, joined by ", ";
    /// empty when there is none.
    [[nodiscard]] std::string header(std::string_view name) const;
    [[nodiscard]] bool has_header(std::string_view name) const noexcept;
};

/// Sends a part of a body.
/// @return false when the client has disconnected: further parts are pointless
using Write = std::function<bool(std::string_view)>;

/// A part of a file that stays open, as a body.
struct FilePart {
    std::shared_ptr<const int> descriptor;  ///< closed with the last part
    std::uint64_t offset = 0;
    std::uint64_t bytes = 0;
};

/// A reply. Content-Length, Date and Connection are added by the host that sends it.
struct Response {
    int status = 200;
    std::string head;  ///< header lines, each with its line end; written by add()
    std::shared_ptr<const std::string> body;  ///< nullptr: none
    /// Instead of `body`: bytes that live as long as the program.
    std::string_view fixed_body = {};
    std::optional<FilePart> file;  ///< instead of `body`: read while it is sent
    /// Instead of `body`: called once to send a body whose length is not known in advance.
    std::function<void(const Write&)> stream;
    bool close = false;  ///< the connection must be closed after the reply

    /// Control characters are removed: they could end the header.
    /// @return this
    Response& add(std::string_view name, std::string_view value);
    /// @return the header's value, or "" when there is none
    [[nodiscard]] std::string header(std::string_view name) const;
    [[nodiscard]] std::string_view bytes() const noexcept {
        return body ? std::string_view(*body) : fixed_body;
    }
    /// Length of the body, unless it is a stream.
    [[nodiscard]] std::uint64_t body_bytes() const noexcept {
        return file ? file->bytes : bytes().size();
    }
};

/// Equality of ASCII words, case-insensitive.
[[nodiscard]] bool same_word(std::string_view a, std::string_view b) noexcept;
[[nodiscard]] std::string_view reason_phrase(int status) noexcept;

/// An error's text without the folders of this machine: of each absolute path only the last
/// component is kept. Where the end of a path is ambiguous (blanks in it), rather too much is
/// removed than too little.
[[nodiscard]] std::string without_folders(std::string_view text);

[[nodiscard]] Response reply(int status, std::string_view content_type, std::string body);
/// A reply with an application/problem+json body. Ref: Nottingham & Wilde, RFC 7807, 2016.
[[nodiscard]] Response problem(int status, const std::string& detail);

/// Whether If-None-Match contains this entity tag (quotes included), by weak comparison. Ref:
/// Fielding et al., RFC 9110, 13.1.2.
[[nodiscard]] bool etag_matches(std::string_view if_none_match, std::string_view etag) noexcept;

/// Whether If-Match contains this entity tag, by strong comparison, or is "*". Ref: RFC
/// 9110, 13.1.1.
[[nodiscard]] bool etag_matches_strongly(std::string_view if_match, std::string_view etag) noexcept;

/// The bytes of a body that a client asks for: [offset, offset + bytes). Ref: RFC 9110, 14.1.2.
struct ByteRange {
    std::uint64_t offset = 0;
    std::uint64_t bytes = 0;
};
/// @param range the header's value: one range is understood, "bytes=0-99", "bytes=100-",
/// "bytes=-100"
/// @param size of the whole body
/// @return nullopt for any other text, which a server may ignore; without bytes for a range that is
/// beyond the end
[[nodiscard]] std::optional<ByteRange> parse_range(std::string_view range,
                                                   std::uint64_t size) noexcept;

/// Takes the first element off the value of a header that is a list: what is before the first
/// comma, without blanks around it.
/// @param list not empty
[[nodiscard]] std::string_view take_element(std::string_view& list) noexcept;

/// Content coding of a body. Ref: RFC 9110, 12.5.3.
enum class Coding { kIdentity, kZstd, kNone };  ///< kNone: the client accepts neither
/// @param accept_encoding the header's value; "": the client has no preference, and gets identity
[[nodiscard]] Coding choose_coding(std::string_view accept_encoding) noexcept;

/// The body of a request as declared by its headers.
struct BodyClaim {
    enum class Kind { kNone, kSome, kMalformed } kind = Kind::kNone;
    std::uint64_t bytes = 0;  ///< for kSome
};
[[nodiscard]] BodyClaim body_claim(const Request& request);

}  // namespace terravox::http
