#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "voxelserver/serve/host/host_names.hpp"
#include "voxelserver/serve/host/message.hpp"
#include "voxelserver/serve/http/routes.hpp"

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

/// Limits how often the clients of an address try a wrong token: kMax times at once, and once more
/// every kPause. What a try beyond that has shown must not be used, so that it tells nothing.
///
/// An address that has shown the right token lately is not limited: a front, or a network behind
/// one address, asks for others as well, whom a guesser must not lock out. Remembers the latest
/// kMaxKept addresses (of IPv6: networks of 64 bits). Reads no clock. Thread-safe.
class TokenTries {
public:
    using Time = std::chrono::steady_clock::time_point;
    static constexpr int kMax = 20;
    static constexpr std::chrono::seconds kPause{1};
    static constexpr std::chrono::minutes kTrusted{10};
    static constexpr std::size_t kMaxKept = 4096;

    /// Counts a try.
    /// @param address numeric, without a port
    /// @return false: too many were wrong before
    [[nodiscard]] bool count(const std::string& address, bool is_right, Time now);

private:
    struct Client {
        Time seen;                  ///< its last try that counted
        Time all_free;              ///< when it has all kMax tries again
        std::optional<Time> right;  ///< when it last showed the right token
    };
    /// With the lock held.
    [[nodiscard]] Client& client(const std::string& address, Time now);

    std::mutex m_mutex;
    std::map<std::string, Client> m_clients;  ///< by neighbourhood
};

/// Validates the head of a request against its route. It depends neither on the world nor on the
/// body, but on the wrong tokens that its client has tried before. Thread-safe.
///
/// The first reason for a refusal applies, in this order:
/// - 400 malformed headers (the connection must be closed)
/// - 421 a host name that is not one of the server's (closed)
/// - 403 a web page of another origin, unless the route is shared with that (closed)
/// - 400 a malformed length of the body
/// - 413 a longer body than the route accepts; most routes accept none
/// - 401 no valid token, where the server has one and the route is not open; 429 instead, with
///   Retry-After, where the client's address has tried too many (TokenTries)
/// - 404 no such route
/// - 405 a method other than that of the route; HEAD is accepted wherever GET is
/// - 411 no body where the route requires one (closed)
class RequestCheck {
public:
    /// @param token "" = none is required
    /// @param names allowed values of the header Host
    /// @param origins of pages that may request what is shared with them
    /// @param clock of the tries of tokens
    RequestCheck(std::string token, HostNames names, SharedOrigins origins = {},
                 std::function<TokenTries::Time()> clock = std::chrono::steady_clock::now);

    /// @return nullopt when the request may be answered
    [[nodiscard]] std::optional<Response> refusal(const RouteFacts& route, const Request& request);

    /// @return false also for a token that is not judged, as too many were wrong before
    [[nodiscard]] bool has_token(const Request& request) {
        return judge(request) == TokenVerdict::kRight;
    }

private:
    enum class TokenVerdict { kNone, kRight, kWrong, kTooMany };
    [[nodiscard]] TokenVerdict judge(const Request& request);
    [[nodiscard]] std::optional<Response> refuse_host(const Request& request) const;
    [[nodiscard]] std::optional<Response> refuse_origin(const RouteFacts& route,
                                                        const Request& request) const;
    [[nodiscard]] std::optional<Response> refuse_without_token(const RouteFacts& route,
                                                               const Request& request);

    const BearerToken m_token;
    const HostNames m_names;
    const SharedOrigins m_origins;
    const std::function<TokenTries::Time()> m_clock;
    TokenTries m_tries;
};

}  // namespace terravox::http
