#include "voxelserver/serve/host/message.hpp"

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "common/util/text.hpp"

namespace terravox::http {
namespace {

bool is_blank(char c) noexcept {
    return c == ' ' || c == '\t' || c == ',';
}

bool is_letter(char c) noexcept {
    return util::lower_case(c) >= 'a' && util::lower_case(c) <= 'z';
}

// Whether a path may begin after this character. Not within a word, such as a file's name or 1/2.
bool may_precede_path(char c) noexcept {
    return std::string_view(" \t\n'\"`([{<=:,;|").find(c) != std::string_view::npos;
}

/// The length of the path at the beginning of the text: up to a character that messages put after
/// names, or to a blank, unless a later word of the same part of the sentence looks like the rest
/// of the path.
std::size_t path_length(std::string_view text) noexcept {
    std::size_t part = 0;
    while (part < text.size() &&
           std::string_view("'\"`,;)]}>|\n").find(text[part]) == std::string_view::npos &&
           !(text[part] == ':' && (part + 1 == text.size() || text[part + 1] == ' ')))
        ++part;
    std::size_t end = std::min(text.find(' '), part);
    for (std::size_t begin = end; begin < part;) {
        const std::size_t next = std::min(text.find(' ', begin + 1), part);
        const std::string_view word = text.substr(begin + 1, next - begin - 1);
        if (word.find('/') != std::string_view::npos &&
            std::any_of(word.begin(), word.end(), is_letter))
            end = next;
        begin = next;
    }
    return end;
}

}  // namespace

bool same_word(std::string_view a, std::string_view b) noexcept {
    return util::equal_but_for_case(a, b);
}

std::string Request::header(std::string_view name) const {
    std::string joined;
    for (const Header& h : headers)
        if (same_word(h.name, name)) {
            if (!joined.empty())
                joined += ", ";
            joined += h.value;
        }
    return joined;
}

bool Request::has_header(std::string_view name) const noexcept {
    return std::any_of(headers.begin(), headers.end(),
                       [&](const Header& h) { return same_word(h.name, name); });
}

Response& Response::add(std::string_view name, std::string_view value) {
    if (head.capacity() < 256)
        head.reserve(256);
    const auto append = [&](std::string_view text) {
        for (const char c : text)
            if (static_cast<unsigned char>(c) >= 0x20 && c != 0x7f)
                head += c;
    };
    append(name);
    head += ": ";
    append(value);
    head += "\r\n";
    return *this;
}

std::string Response::header(std::string_view name) const {
    std::size_t at = 0;
    while (at < head.size()) {
        const std::size_t colon = head.find(": ", at);
        const std::size_t end = head.find("\r\n", at);
        if (same_word(std::string_view(head).substr(at, colon - at), name))
            return head.substr(colon + 2, end - colon - 2);
        at = end + 2;
    }
    return {};
}

std::string_view reason_phrase(int status) noexcept {
    switch (status) {
        case 200: return "OK";
        case 201: return "Created";
        case 204: return "No Content";
        case 206: return "Partial Content";
        case 304: return "Not Modified";
        case 308: return "Permanent Redirect";
        case 400: return "Bad Request";
        case 401: return "Unauthorized";
        case 403: return "Forbidden";
        case 404: return "Not Found";
        case 405: return "Method Not Allowed";
        case 406: return "Not Acceptable";
        case 408: return "Request Timeout";
        case 411: return "Length Required";
        case 412: return "Precondition Failed";
        case 413: return "Content Too Large";
        case 414: return "URI Too Long";
        case 415: return "Unsupported Media Type";
        case 416: return "Range Not Satisfiable";
        case 421: return "Misdirected Request";
        case 429: return "Too Many Requests";
        case 431: return "Request Header Fields Too Large";
        case 500: return "Internal Server Error";
        case 503: return "Service Unavailable";
        case 505: return "HTTP Version Not Supported";
        default: return status < 500 ? "Request Failed" : "Server Error";
    }
}

std::string without_folders(std::string_view text) {
    std::string out;
    while (!text.empty()) {
        if (text.front() == '/' && (out.empty() || may_precede_path(out.back()))) {
            const std::string_view path = text.substr(0, path_length(text));
            const std::size_t last = path.find_last_not_of('/');
            if (last != std::string_view::npos)
                out += path.substr(path.rfind('/', last) + 1);
            text.remove_prefix(std::max<std::size_t>(path.size(), 1));
        } else {
            out += text.front();
            text.remove_prefix(1);
        }
    }
    return out;
}

Response reply(int status, std::string_view content_type, std::string body) {
    Response out;
    out.status = status;
    out.add("Content-Type", content_type);
    out.body = std::make_shared<const std::string>(std::move(body));
    return out;
}

Response problem(int status, const std::string& detail) {
    const nlohmann::json json = {{"type", "about:blank"},
                                 {"title", std::string(reason_phrase(status))},
                                 {"status", status},
                                 {"detail", detail}};
    Response out =
        reply(status, "application/problem+json",
              json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
    out.add("Cache-Control", "no-store");
    return out;
}

std::optional<ByteRange> parse_range(std::string_view range, std::uint64_t size) noexcept {
    constexpr std::string_view kUnit = "bytes=";
    if (range.substr(0, kUnit.size()) != kUnit)
        return std::nullopt;
    range.remove_prefix(kUnit.size());
    const std::size_t dash = range.find('-');
    if (dash == std::string_view::npos)
        return std::nullopt;
    const auto number = [](std::string_view text) -> std::optional<std::uint64_t> {
        std::uint64_t value = 0;
        const auto end = std::from_chars(text.data(), text.data() + text.size(), value);
        if (end.ec != std::errc{} || end.ptr != text.data() + text.size())
            return std::nullopt;
        return value;
    };
    const std::string_view from = range.substr(0, dash);
    const std::string_view to = range.substr(dash + 1);
    const auto last = number(to);
    if (from.empty()) {  // so many bytes of the end
        if (!last)
            return std::nullopt;
        const std::uint64_t bytes = std::min(*last, size);
        return ByteRange{size - bytes, bytes};
    }
    const auto first = number(from);
    if (!first || (!to.empty() && (!last || *last < *first)))
        return std::nullopt;
    if (*first >= size)
        return ByteRange{size, 0};
    const std::uint64_t rest = size - *first;
    return ByteRange{*first, to.empty() ? rest : std::min(*last - *first, rest - 1) + 1};
}

namespace {

/// @param weak whether "W/" before a tag of the list is ignored; else such a tag matches none
bool is_in_tags(std::string_view list, std::string_view etag, bool weak) noexcept {
    std::string_view rest = list;
    for (;;) {
        while (!rest.empty() && is_blank(rest.front()))
            rest.remove_prefix(1);
        if (rest.empty())
            return false;
        if (rest.front() == '*')
            return true;
        const bool is_weak = rest.substr(0, 2) == "W/";
        if (is_weak)
            rest.remove_prefix(2);
        if (rest.empty() || rest.front() != '"')
            return false;  // not a list of entity tags
        const std::size_t end = rest.find('"', 1);
        if (end == std::string_view::npos)
            return false;
        if (rest.substr(0, end + 1) == etag && (weak || !is_weak))
            return true;
        rest.remove_prefix(end + 1);
    }
}

}  // namespace

bool etag_matches(std::string_view if_none_match, std::string_view etag) noexcept {
    return is_in_tags(if_none_match, etag, true);
}

bool etag_matches_strongly(std::string_view if_match, std::string_view etag) noexcept {
    return is_in_tags(if_match, etag, false);
}

std::string_view take_element(std::string_view& list) noexcept {
    const std::size_t end = std::min(list.find(','), list.size());
    const std::string_view out = util::trimmed(list.substr(0, end));
    list.remove_prefix(std::min(end + 1, list.size()));
    return out;
}

Coding choose_coding(std::string_view accept_encoding) noexcept {
    bool zstd = false;
    bool identity = true;
    bool named_identity = false;
    while (!accept_encoding.empty()) {
        const std::string_view one = take_element(accept_encoding);
        const std::size_t semicolon = std::min(one.find(';'), one.size());
        const std::string_view name = util::trimmed(one.substr(0, semicolon));
        const std::string_view weight =
            util::trimmed(one.substr(std::min(semicolon + 1, one.size())));
        // q=0, q=0.0 ...: not acceptable.
        const bool wanted =
            !(weight.size() >= 3 && util::lower_case(weight[0]) == 'q' && weight[1] == '=' &&
              weight.find_first_not_of("0.", 2) == std::string_view::npos);
        if (same_word(name, "zstd"))
            zstd = wanted;
        if (same_word(name, "identity")) {
            identity = wanted;
            named_identity = true;
        }
        if (name == "*" && !wanted && !named_identity)
            identity = false;
    }
    return zstd ? Coding::kZstd : identity ? Coding::kIdentity : Coding::kNone;
}

BodyClaim body_claim(const Request& request) {
    using Kind = BodyClaim::Kind;
    BodyClaim claim;
    bool seen = false;
    for (const Header& h : request.headers) {
        if (same_word(h.name, "Transfer-Encoding"))
            return {Kind::kMalformed, 0};
        if (!same_word(h.name, "Content-Length"))
            continue;
        std::uint64_t bytes = 0;
        const auto [end, error] =
            std::from_chars(h.value.data(), h.value.data() + h.value.size(), bytes);
        if (error == std::errc::result_out_of_range)
            bytes = UINT64_MAX;
        // Two different lengths: a proxy on the way could use the other one (request smuggling).
        if (error == std::errc::invalid_argument || end != h.value.data() + h.value.size() ||
            h.value.empty() || seen)
            return {Kind::kMalformed, 0};
        seen = true;
        claim = {bytes > 0 ? Kind::kSome : Kind::kNone, bytes};
    }
    return claim;
}

}  // namespace terravox::http
