#include "voxelserver/http/message.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace terravox::http {
namespace {

char lower(char c) noexcept { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool is_blank(char c) noexcept { return c == ' ' || c == '\t' || c == ','; }

}  // namespace

bool same_word(std::string_view a, std::string_view b) noexcept {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) { return lower(x) == lower(y); });
}

std::string Request::header(std::string_view name) const {
    std::string joined;
    for (const Header& h : headers)
        if (same_word(h.name, name)) joined += (joined.empty() ? "" : ", ") + h.value;
    return joined;
}

bool Request::has_header(std::string_view name) const noexcept {
    return std::any_of(headers.begin(), headers.end(), [&](const Header& h) { return same_word(h.name, name); });
}

const std::string* Response::header(std::string_view name) const noexcept {
    const auto at = std::find_if(headers.begin(), headers.end(), [&](const Header& h) { return same_word(h.name, name); });
    return at == headers.end() ? nullptr : &at->value;
}

std::string_view reason_phrase(int status) noexcept {
    switch (status) {
        case 200: return "OK";
        case 204: return "No Content";
        case 304: return "Not Modified";
        case 400: return "Bad Request";
        case 404: return "Not Found";
        case 405: return "Method Not Allowed";
        case 408: return "Request Timeout";
        case 411: return "Length Required";
        case 413: return "Content Too Large";
        case 431: return "Request Header Fields Too Large";
        case 500: return "Internal Server Error";
        case 503: return "Service Unavailable";
        case 505: return "HTTP Version Not Supported";
        default: return status < 500 ? "Request Failed" : "Server Error";
    }
}

Response reply(int status, std::string content_type, std::string body) {
    Response out;
    out.status = status;
    out.headers.push_back({"Content-Type", std::move(content_type)});
    out.body = std::make_shared<const std::string>(std::move(body));
    return out;
}

Response problem(int status, const std::string& detail) {
    const nlohmann::json json = {{"type", "about:blank"}, {"title", std::string(reason_phrase(status))}, {"status", status}, {"detail", detail}};
    Response out = reply(status, "application/problem+json", json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
    out.headers.push_back({"Cache-Control", "no-store"});
    return out;
}

bool etag_matches(std::string_view if_none_match, std::string_view etag) noexcept {
    std::string_view rest = if_none_match;
    for (;;) {
        while (!rest.empty() && is_blank(rest.front())) rest.remove_prefix(1);
        if (rest.empty()) return false;
        if (rest.front() == '*') return true;
        if (rest.substr(0, 2) == "W/") rest.remove_prefix(2);
        if (rest.empty() || rest.front() != '"') return false;  // not a list of entity tags
        const std::size_t end = rest.find('"', 1);
        if (end == std::string_view::npos) return false;
        if (rest.substr(0, end + 1) == etag) return true;
        rest.remove_prefix(end + 1);
    }
}

BodyClaim body_claim(const Request& request) {
    if (request.has_header("Transfer-Encoding")) return BodyClaim::kMalformed;
    BodyClaim claim = BodyClaim::kNone;
    for (const Header& h : request.headers) {
        if (!same_word(h.name, "Content-Length")) continue;
        const bool number = !h.value.empty() && std::all_of(h.value.begin(), h.value.end(), [](char c) { return c >= '0' && c <= '9'; });
        if (!number) return BodyClaim::kMalformed;
        if (h.value.find_first_not_of('0') != std::string::npos) claim = BodyClaim::kSome;
    }
    return claim;
}

}  // namespace terravox::http
