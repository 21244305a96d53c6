#include "voxelserver/serve/http/dispatcher.hpp"

#include "voxelserver/serve/http/archive_route.hpp"
#include "voxelserver/serve/http/batch_route.hpp"
#include "voxelserver/serve/http/box_routes.hpp"
#include "voxelserver/serve/http/gkot_routes.hpp"
#include "voxelserver/serve/http/job_routes.hpp"
#include "voxelserver/serve/http/map_route.hpp"
#include "voxelserver/serve/http/page_routes.hpp"
#include "voxelserver/serve/http/state_routes.hpp"
#include "voxelserver/serve/http/view_place.hpp"

namespace terravox::http {

Dispatcher::Dispatcher(Service service, const RequestCounts& counts)
    : m_service(std::move(service)),
      m_counts(counts),
      m_world(m_service.world.info(), m_service.edition) {}

Response Dispatcher::run(Route route, const RouteRequest& call) {
    if (auto refused = refuse_edition(call.request))
        return std::move(*refused);
    return call_handler(route, call);
}

std::optional<Response> Dispatcher::refuse_edition(const Request& request) const {
    const std::string wanted = request.header(kEditionHeader);
    if (wanted.empty() || wanted == m_service.edition)
        return std::nullopt;
    return problem(412,
                   "the world is of another edition than the request wants; allowed: that of "
                   "/v2/world, or no header " +
                       std::string(kEditionHeader));
}

Response Dispatcher::call_handler(Route route, const RouteRequest& call) {
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
        case Route::kStats: return answer_stats(m_service, call, m_counts, uptime_s());
        case Route::kMetrics: return answer_metrics(m_service, m_counts, uptime_s());
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

double Dispatcher::uptime_s() const noexcept {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - m_start).count();
}

}  // namespace terravox::http
