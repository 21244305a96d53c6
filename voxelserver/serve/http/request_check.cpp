#include "voxelserver/serve/http/request_check.hpp"

#include <algorithm>
#include <string_view>

namespace terravox::http {
namespace {

Response and_close(Response out) {
    out.close = true;
    return out;
}

// Proxies and this server must not interpret a request differently. Ref: RFC 9112, 3.2 and 5.1.
std::string fault_of(const Request& request) {
    const auto is_token = [](char c) {
        return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
               std::string_view("!#$%&'*+-.^_`|~").find(c) != std::string_view::npos;
    };
    for (const Header& h : request.headers)
        if (h.name.empty() || !std::all_of(h.name.begin(), h.name.end(), is_token))
            return "a header's name is no token";
    const auto hosts = std::count_if(request.headers.begin(), request.headers.end(),
                                     [](const Header& h) { return same_word(h.name, "Host"); });
    if (hosts > 1)
        return std::to_string(hosts) + " headers Host; allowed: one";
    return {};
}

std::optional<Response> refuse_headers(const Request& request) {
    if (const std::string wrong = fault_of(request); !wrong.empty())
        return and_close(problem(400, "read the request: " + wrong));
    return std::nullopt;
}

bool takes_body(const RouteFacts& route, const Request& request) {
    return request.method == "POST" && is_allowed(route.methods, request.method);
}

std::optional<Response> refuse_body(const RouteFacts& route, const Request& request,
                                    const BodyClaim& claim) {
    if (claim.kind == BodyClaim::Kind::kMalformed)
        return problem(400,
                       "read the request: a Transfer-Encoding, two Content-Lengths, or one that is "
                       "no number; allowed: none, or one number");
    const std::size_t max = takes_body(route, request) ? route.max_body_bytes : 0;
    if (claim.bytes > max)
        return problem(
            413, "read the request: a body of " + std::to_string(claim.bytes) +
                     " bytes; allowed: " + (max > 0 ? "up to " + std::to_string(max) : "none"));
    return std::nullopt;
}

std::optional<Response> refuse_path(const RouteFacts& route, const Request& request) {
    if (route.route == Route::kUnknown)
        return problem(
            404, "nothing at " + std::string(request.path) + "; /openapi.json lists what there is");
    return std::nullopt;
}

std::optional<Response> refuse_method(const RouteFacts& route, const Request& request) {
    if (is_allowed(route.methods, request.method))
        return std::nullopt;
    const std::string allowed(text_of(route.methods));
    return problem(405, "method " + std::string(request.method) + "; allowed: " + allowed)
        .add("Allow", allowed);
}

// A body that arrives nevertheless must not be parsed as the next request.
std::optional<Response> refuse_missing_body(const RouteFacts& route, const Request& request,
                                            const BodyClaim& claim) {
    if (takes_body(route, request) && claim.kind == BodyClaim::Kind::kNone)
        return and_close(problem(411, "read the request: no Content-Length, or 0; allowed: 1 to " +
                                          std::to_string(route.max_body_bytes)));
    return std::nullopt;
}

}  // namespace

RequestCheck::RequestCheck(std::string token, sockets::HttpNames names, SharedOrigins origins,
                           std::function<TokenTries::Time()> clock)
    : m_token(std::move(token)),
      m_names(std::move(names)),
      m_origins(std::move(origins)),
      m_clock(std::move(clock)) {}

std::optional<Response> RequestCheck::refusal(const RouteFacts& route, const Request& request) {
    if (auto out = refuse_headers(request))
        return out;
    if (auto out = refuse_host(request))
        return out;
    if (auto out = refuse_origin(route, request))
        return out;
    const BodyClaim claim = body_claim(request);
    if (auto out = refuse_body(route, request, claim))
        return out;
    if (auto out = refuse_without_token(route, request))
        return out;
    if (auto out = refuse_path(route, request))
        return out;
    if (auto out = refuse_method(route, request))
        return out;
    return refuse_missing_body(route, request, claim);
}

// HTTP/1.0 allows the header to be omitted; browsers always send it.
std::optional<Response> RequestCheck::refuse_host(const Request& request) const {
    const std::string host = request.header("Host");
    if (request.has_header("Host") && !m_names.allow(host))
        return and_close(problem(421, "read the request: the host '" + host +
                                          "' is no name of this server; allowed: localhost, a "
                                          "numeric address, or a name given by --public-name"));
    return std::nullopt;
}

std::optional<Response> RequestCheck::refuse_origin(const RouteFacts& route,
                                                    const Request& request) const {
    const std::string host = request.header("Host");
    const std::string origin = request.header("Origin");
    if (route.shared && m_origins.allow(origin))
        return std::nullopt;
    if (sockets::from_another_origin({host, origin, request.header("Sec-Fetch-Site"),
                                      request.header("Sec-Fetch-Mode"),
                                      request.header("Sec-Fetch-Dest"), request.method}))
        return and_close(problem(403,
                                 "read the request: a web page of another origin makes it; "
                                 "allowed: the server's own page, and programs"));
    return std::nullopt;
}

RequestCheck::TokenVerdict RequestCheck::judge(const Request& request) {
    if (!m_token.is_required() || !request.has_header("Authorization"))
        return TokenVerdict::kNone;
    const bool is_right = m_token.is_in(request);
    if (!m_tries.count(std::string(request.client), is_right, m_clock()))
        return TokenVerdict::kTooMany;
    return is_right ? TokenVerdict::kRight : TokenVerdict::kWrong;
}

std::optional<Response> RequestCheck::refuse_without_token(const RouteFacts& route,
                                                           const Request& request) {
    if (route.open || !m_token.is_required())
        return std::nullopt;
    switch (judge(request)) {
        case TokenVerdict::kRight: return std::nullopt;
        case TokenVerdict::kTooMany:
            return problem(429,
                           "too many wrong tokens from this address; allowed: one more each second")
                .add("Retry-After", std::to_string(TokenTries::kPause.count()));
        case TokenVerdict::kNone:
        case TokenVerdict::kWrong: break;
    }
    return problem(401, "the request has no valid token; allowed: Authorization: Bearer TOKEN")
        .add("WWW-Authenticate", "Bearer");
}

}  // namespace terravox::http
