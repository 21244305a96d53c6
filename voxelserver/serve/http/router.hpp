#pragma once

#include <optional>
#include <string>

#include "common/util/stage_times.hpp"
#include "voxelserver/serve/host/host.hpp"
#include "voxelserver/serve/host/host_names.hpp"
#include "voxelserver/serve/http/request_check.hpp"
#include "voxelserver/serve/http/route_answers.hpp"
#include "voxelserver/serve/http/service.hpp"

namespace terravox::http {

/// Answers requests about one world: a function of the request, without sockets. Thread-safe.
///
/// It finds the route (routes.hpp), has the request's head validated by RequestCheck, calls the
/// handler of the route (route_answers.hpp), and counts the replies; exceptions become replies as
/// well (service.hpp). A request that names another edition than that of the world gets 412, and no
/// handler is called. docs/openapi.json documents the replies of each route for clients. Errors are
/// application/problem+json. No reply contains the name of a folder of this machine.
class Router : public RequestHandler {
public:
    /// @param token  "" = no token is required
    /// @param names  allowed values of the header Host
    /// @param origins of pages that may read what is shared with them
    explicit Router(Service service, std::string token = "", HostNames names = HostNames(),
                    SharedOrigins origins = {});

    [[nodiscard]] std::optional<Response> refusal(const Request& request) override;
    [[nodiscard]] Response handle(const Request& request) override;
    [[nodiscard]] Response refuse(int status, const std::string& detail) override {
        m_counts.add(Route::kRefused, status, 0);
        return problem(status, detail);
    }
    void count_sent(std::uint64_t bytes) noexcept override { m_counts.add_bytes(bytes); }

    [[nodiscard]] RequestCounts& counts() noexcept { return m_counts; }

private:
    [[nodiscard]] Response answer(const RouteMatch& match, const Request& request);
    [[nodiscard]] std::optional<Response> refuse_edition(const Request& request) const;
    /// @throws whatever the handler throws
    [[nodiscard]] Response call_handler(Route route, const RouteRequest& call);

    /// What the reply's headers say depends on the request and its route, not on the content.
    [[nodiscard]] Response fit_to(const RouteFacts& route, const Request& request,
                                  Response out) const;

    Service m_service;
    RequestCounts m_counts;
    const SharedOrigins m_origins;
    RequestCheck m_check;
    const WorldRoute m_world;
    const util::Stopwatch m_clock;  ///< since the start
};

}  // namespace terravox::http
