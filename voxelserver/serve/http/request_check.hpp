#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>

#include "voxelserver/serve/http/bearer_token.hpp"
#include "voxelserver/serve/http/message.hpp"
#include "voxelserver/serve/http/routes.hpp"
#include "voxelserver/serve/http/shared_origins.hpp"
#include "voxelserver/serve/http/token_tries.hpp"
#include "voxelserver/serve/sockets/http_host.hpp"

namespace terravox::http {

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
    RequestCheck(std::string token, sockets::HttpNames names, SharedOrigins origins = {},
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
    const sockets::HttpNames m_names;
    const SharedOrigins m_origins;
    const std::function<TokenTries::Time()> m_clock;
    TokenTries m_tries;
};

}  // namespace terravox::http
