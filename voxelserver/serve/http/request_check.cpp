#include "voxelserver/serve/http/request_check.hpp"

#include <algorithm>
#include <string_view>

#include "common/util/error.hpp"
#include "voxelserver/serve/sockets/socket.hpp"

namespace terravox::http {
namespace {

// Takes the same time for every token, so that the time does not reveal how much of it was right.
bool same_secret(std::string_view given, std::string_view wanted) noexcept {
    unsigned difference = given.size() == wanted.size() ? 0 : 1;
    for (std::size_t i = 0; i < wanted.size(); ++i)
        difference |= static_cast<unsigned char>(wanted[i]) ^
                      static_cast<unsigned char>(given.empty() ? 0 : given[i % given.size()]);
    return difference == 0;
}

}  // namespace

bool BearerToken::is_in(const Request& request) const {
    const std::string given = request.header("Authorization");
    constexpr std::string_view kScheme = "Bearer ";
    return is_required() && given.size() > kScheme.size() &&
           same_word(std::string_view(given).substr(0, kScheme.size()), kScheme) &&
           same_secret(std::string_view(given).substr(kScheme.size()), m_secret);
}

namespace {

constexpr std::string_view kAny = "*";

// As browsers write an origin: lower case, no path, no default port is added.
bool is_origin(std::string_view text) noexcept {
    constexpr std::size_t kMax_bytes = 300;
    if (text.size() > kMax_bytes)
        return false;
    for (const std::string_view scheme : {"https://", "http://"})
        if (text.starts_with(scheme)) {
            const std::string_view host = text.substr(scheme.size());
            const auto fits = [](char c) {
                return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '.' ||
                       c == ':' || c == '[' || c == ']';
            };
            return !host.empty() && std::all_of(host.begin(), host.end(), fits);
        }
    return false;
}

}  // namespace

SharedOrigins::SharedOrigins(std::vector<std::string> origins) : m_origins(std::move(origins)) {
    for (const std::string& origin : m_origins)
        if (!is_origin(origin) && (origin != kAny || m_origins.size() > 1))
            throw util::UsageError("share the archive with pages of '" + origin +
                                   "'; allowed: origins such as https://example.org, in lower "
                                   "case, without a path; or * alone");
}

bool SharedOrigins::is_any() const noexcept {
    return m_origins.size() == 1 && m_origins.front() == kAny;
}

bool SharedOrigins::allow(std::string_view origin) const noexcept {
    if (origin.empty())
        return false;
    return is_any() || std::find(m_origins.begin(), m_origins.end(), origin) != m_origins.end();
}

void SharedOrigins::add_headers(const Request& request, Response& reply) const {
    if (m_origins.empty())
        return;
    const std::string origin = request.header("Origin");
    // Caches must not give the reply for one page, or for no page, to another one.
    if (!is_any())
        reply.add("Vary", "Origin");
    if (!is_any() && !allow(origin))
        return;
    reply.add("Access-Control-Allow-Origin", is_any() ? kAny : std::string_view(origin));
    reply.add("Access-Control-Expose-Headers", "Accept-Ranges, Content-Range, ETag, Retry-After");
}

TokenTries::Client& TokenTries::client(const std::string& address, Time now) {
    const auto endpoint = sockets::numeric_endpoint(address, 0);
    const std::string name = endpoint ? endpoint->neighbourhood() : address;
    if (m_clients.size() >= kMaxKept && !m_clients.contains(name))
        m_clients.erase(std::min_element(
            m_clients.begin(), m_clients.end(),
            [](const auto& a, const auto& b) { return a.second.seen < b.second.seen; }));
    return m_clients.try_emplace(name, Client{now, now, std::nullopt}).first->second;
}

bool TokenTries::count(const std::string& address, bool is_right, Time now) {
    const std::lock_guard lock(m_mutex);
    Client& one = client(address, now);
    const bool is_trusted = one.right && now - *one.right < kTrusted;
    if (!is_trusted && one.all_free + kPause > now + kMax * kPause)
        return false;
    one.seen = now;
    if (is_right)
        one.right = now;
    else  // no more than kMax are owed, however many a trusted address has made
        one.all_free = std::min(std::max(one.all_free, now) + kPause, now + kMax * kPause);
    return true;
}

namespace {

Response and_close(Response out) {
    out.close = true;
    return out;
}

// Proxies and this server must not interpret a request differently. Ref: RFC 9112, 3.2 and 5.1.
std::string describe_fault(const Request& request) {
    const auto is_token = [](char c) {
        return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
               std::string_view("!#$%&'*+-.^_`|~").find(c) != std::string_view::npos;
    };
    for (const Header& h : request.headers)
        if (h.name.empty() || !std::all_of(h.name.begin(), h.name.end(), is_token))
            return "a header's name is no token";
    const auto hosts = std::count_if(request.headers.begin(), request.headers.end(),
                                     [](const Header& h) { return same_word(h.name, "Host"); });
    if (hosts == 0 && request.version == "1.1")
        return "HTTP/1.1 without the header Host";
    if (hosts > 1)
        return std::to_string(hosts) + " headers Host; allowed: one";
    return {};
}

std::optional<Response> refuse_headers(const Request& request) {
    if (const std::string wrong = describe_fault(request); !wrong.empty())
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
    const std::string allowed(to_text(route.methods));
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

RequestCheck::RequestCheck(std::string token, HostNames names, SharedOrigins origins,
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
    if (route.shared && m_origins.allow(request.header("Origin")))
        return std::nullopt;
    if (from_another_origin(request))
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
