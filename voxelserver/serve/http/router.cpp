#include "voxelserver/serve/http/router.hpp"

#include "voxelserver/serve/http/route_answers.hpp"
#include "voxelserver/serve/http/service.hpp"

namespace terravox::http {

Router::Router(Service service, std::string token, HostNames names, SharedOrigins origins)
    : m_service(std::move(service)),
      m_origins(std::move(origins)),
      m_check(std::move(token), std::move(names), m_origins),
      m_world(m_service.world.info(), m_service.edition) {}

std::optional<Response> Router::refusal(const Request& request) {
    const RouteFacts& route = match_route(request.path).facts;
    std::optional<Response> out = m_check.refusal(route, request);
    if (!out)
        return out;
    m_counts.add(route.route, out->status, 0);
    return fit_to(route, request, std::move(*out));
}

Response Router::handle(const Request& request) {
    const util::Stopwatch clock;
    const RouteMatch match = match_route(request.path);
    Response out = fit_to(match.facts, request, answer(match, request));
    m_counts.add(match.facts.route, out.status, clock.seconds());
    return out;
}

Response Router::answer(const RouteMatch& match, const Request& request) {
    try {
        if (auto refused = m_check.refusal(match.facts, request))
            return std::move(*refused);
        if (auto refused = refuse_edition(request))
            return std::move(*refused);
        return call_handler(match.facts.route, {request, match.parts, m_check.has_token(request)});
    } catch (...) {
        return reply_to_current_exception(request);
    }
}

Response Router::fit_to(const RouteFacts& route, const Request& request, Response out) const {
    if (route.shared)
        m_origins.add_headers(request, out);
    return out;
}

std::optional<Response> Router::refuse_edition(const Request& request) const {
    const std::string wanted = request.header(kEditionHeader);
    if (wanted.empty() || wanted == m_service.edition)
        return std::nullopt;
    return problem(412,
                   "the world is of another edition than the request wants; allowed: that of "
                   "/v2/world, or no header " +
                       std::string(kEditionHeader));
}

Response Router::call_handler(Route route, const RouteRequest& call) {
    switch (route) {
        case Route::kPage:
        case Route::kPageFile: return answer_page(call);
        case Route::kView: return redirect_to_viewer();
        case Route::kViewPage:
        case Route::kViewFile: return answer_viewer(call);
        case Route::kViewPlace: return json_reply(view_place(m_service), call.request);
        case Route::kViewAppearance: return answer_appearance(call);
        case Route::kOpenApi: return answer_open_api(call);
        case Route::kHealth: return answer_health(m_service, call);
        case Route::kWorld: return m_world.answer(call.request);
        case Route::kBox: return answer_box(m_service, call);
        case Route::kBatch: return answer_batch(m_service, call);
        case Route::kArchive: return answer_archive(m_service, call);
        case Route::kColumn: return answer_column(m_service, call);
        case Route::kSquares:
            return json_reply(squares_json(m_service.squares(), m_service.world.info()),
                              call.request);
        case Route::kCached: return answer_cached(m_service, call);
        case Route::kStats: return answer_stats(m_service, call, m_counts, m_clock.seconds());
        case Route::kMetrics: return answer_metrics(m_service, m_counts, m_clock.seconds());
        case Route::kMapTile: return answer_map_tile(m_service, call);
        case Route::kGkotBox: return answer_gkot_box(m_service, call);
        case Route::kGkotOrigin: return answer_gkot_origin(m_service, call);
        case Route::kJobs: return answer_jobs(m_service, call);
        case Route::kJob: return answer_job(m_service, call);
        case Route::kJobResult: return answer_job_result(m_service, call);
        case Route::kUnknown:
        case Route::kRefused: break;
    }
    return problem(404, "nothing there");
}

}  // namespace terravox::http
