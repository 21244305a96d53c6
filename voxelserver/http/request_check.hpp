#pragma once

#include <optional>
#include <string>

#include "voxelserver/http/bearer_token.hpp"
#include "voxelserver/http/message.hpp"
#include "voxelserver/http/routes.hpp"
#include "voxelserver/sockets/http_host.hpp"

namespace terravox::http {

/// Compares the head of a request with what its route accepts. It knows neither the world nor the
/// body. Immutable, thread-safe.
///
/// The first reason to refuse counts, in this order:
/// - 400 malformed headers (the connection is to be closed)
/// - 421 a host name that is none of the server's (closed)
/// - 403 a web page of another origin (closed)
/// - 400 a malformed length of the body
/// - 413 a longer body than the route accepts; most routes accept none
/// - 401 no valid token, where the server has one and the route is not open
/// - 404 no such route
/// - 405 a method other than that of the route; HEAD is accepted wherever GET is
/// - 411 no body where the route needs one (closed)
class RequestCheck {
public:
    /// @param token "" = none is required
    /// @param names that requests may have in their header Host
    RequestCheck(std::string token, sockets::HttpNames names);

    /// @return nothing where the request may be answered
    [[nodiscard]] std::optional<Response> refusal(const RouteFacts& route,
                                                  const Request& request) const;

    [[nodiscard]] bool has_token(const Request& request) const { return m_token.is_in(request); }

private:
    [[nodiscard]] std::optional<Response> refuse_host(const Request& request) const;
    [[nodiscard]] std::optional<Response> refuse_without_token(const RouteFacts& route,
                                                               const Request& request) const;

    const BearerToken m_token;
    const sockets::HttpNames m_names;
};

}  // namespace terravox::http
