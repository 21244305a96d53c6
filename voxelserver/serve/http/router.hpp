#pragma once

#include <optional>
#include <string>

#include "voxelserver/serve/http/dispatcher.hpp"
#include "voxelserver/serve/http/request_check.hpp"
#include "voxelserver/serve/http/request_handler.hpp"
#include "voxelserver/serve/http/service.hpp"
#include "voxelserver/serve/sockets/http_host.hpp"

namespace terravox::http {

/// Answers requests about one world: a function of the request, without sockets. Thread-safe.
///
/// It finds the route (routes.hpp), has the request's head validated by RequestCheck and the
/// request answered by the Dispatcher, and counts the replies; exceptions become replies as well
/// (error_reply.hpp). docs/openapi.json documents the replies of each route for clients. Errors are
/// application/problem+json. No reply contains the name of a folder of this machine.
class Router : public RequestHandler {
public:
    /// @param token  "" = no token is required
    /// @param names  allowed values of the header Host
    /// @param origins of pages that may read what is shared with them
    explicit Router(Service service, std::string token = "",
                    sockets::HttpNames names = sockets::HttpNames(), SharedOrigins origins = {});

    [[nodiscard]] std::optional<Response> refusal(const Request& request) override;
    [[nodiscard]] Response handle(const Request& request) override;
    void count_refused(int status) noexcept override { m_counts.add(Route::kRefused, status, 0); }
    void count_sent(std::uint64_t bytes) noexcept override { m_counts.add_bytes(bytes); }

    [[nodiscard]] RequestCounts& counts() noexcept { return m_counts; }

private:
    [[nodiscard]] Response answer(const RouteMatch& match, const Request& request);

    /// What the reply's headers say depends on the request and its route, not on the content.
    [[nodiscard]] Response fit_to(const RouteFacts& route, const Request& request,
                                  Response out) const;

    RequestCounts m_counts;
    const SharedOrigins m_origins;
    RequestCheck m_check;
    Dispatcher m_dispatcher;
};

}  // namespace terravox::http
