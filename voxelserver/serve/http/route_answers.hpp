#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "voxelserver/serve/http/service.hpp"

namespace terravox::http {

/// GET /v2/archive.tvx: the file of the box archive that is served, as it is now; 404 where the
/// world is no archive of this machine. Each request opens the file, so that a reply is of one
/// archive, however it is replaced meanwhile. Its tag is made of size and time: servers that share
/// an archive, or have copies with its time, agree about it.
[[nodiscard]] Response answer_archive(const Service& service, const RouteRequest& call);

inline constexpr const char* kBatchMediaType = "application/vnd.terravox.boxes";
inline constexpr std::size_t kMaxBatchBoxes = 4096;
/// Size of the record that precedes each box (docs/formats/http.md).
inline constexpr std::size_t kBatchRecordBytes = 24;

/// POST /v2/boxes with {"boxes": [[level, bx, by, bz], ...]}: 200 a stream of records, each box as
/// soon as it is ready; 400, 413, 415, 503 too many batches at the same time. An unavailable box is
/// a record with the reason; it does not delay the others.
[[nodiscard]] Response answer_batch(Service& service, const RouteRequest& call);

/// GET /v2/boxes/{level}/{bx}/{by}/{bz}: 200 the box, zstd or uncompressed; 204 air, 304, 400, 404,
/// 406, 500, 503.
[[nodiscard]] Response answer_box(Service& service, const RouteRequest& call);

/// GET /v2/columns/{level}/{bx}/{bz}: 200 JSON, 400, 404, 500. by_begin, by_end: half-open, boxes
/// of that level, equal for air; min_y, max_y: the same in voxels of level 0, clipped to the bounds
/// of the world.
[[nodiscard]] Response answer_column(Service& service, const RouteRequest& call);

/// GET /gkot/box?...: the first system's reply (docs/formats/http.md); 400 for a parameter that is
/// missing, repeated or out of range, 413 for more voxels than the memory allows, 500, 503.
[[nodiscard]] Response answer_gkot_box(Service& service, const RouteRequest& call);

/// GET /gkot/origin.json?tmx&tmy: 200 JSON, 400.
[[nodiscard]] Response answer_gkot_origin(Service& service, const RouteRequest& call);

/// Limits of jobs, and how many there are, as a JSON object; null where the server makes none.
[[nodiscard]] nlohmann::json jobs_json(jobs::JobQueue* queue);

/// GET /v2/jobs: 200 JSON, the limits of jobs and how many there are; POST: 201 JSON, the state of
/// a new job, with its address in Location; 400, 503. Both 404 where the server makes no analyses.
[[nodiscard]] Response answer_jobs(Service& service, const RouteRequest& call);

/// GET /v2/jobs/{id}: 200 JSON, the state of a job; DELETE: 204, it ends and its files are removed;
/// 404.
[[nodiscard]] Response answer_job(Service& service, const RouteRequest& call);

/// GET /v2/jobs/{id}/result.tif: 200 or 206, the raster of a job that is done; 404, 416.
[[nodiscard]] Response answer_job_result(Service& service, const RouteRequest& call);

/// GET /map/{z}/{x}/{y}.png: 200 a tile of the top view (voxelserver/serve/map/map_tiles.hpp), 304,
/// 400, 404 no such zoom, 500, 503. An incomplete tile has the header `Terravox-Complete: no` and
/// must not be cached.
[[nodiscard]] Response answer_map_tile(Service& service, const RouteRequest& call);

/// What browsers are told about a page and each of its files, its worker among them: it loads
/// nothing of other origins, asks none, and must not be embedded in other pages.
/// @param archive_origin the one origin that the page may ask, "https://HOST"; empty: none
[[nodiscard]] Response add_page_headers(Response out, std::string_view archive_origin = {});

/// GET / and /page/{name}: the page and its files, which are compiled into the program; 404 for an
/// unknown name.
[[nodiscard]] Response answer_page(const RouteRequest& call);

/// GET /view: 308 to /view/, where the relative addresses of the viewer lead to its files.
[[nodiscard]] Response redirect_to_viewer();

/// GET /view/ and /view/viewer/{file}: the viewer's page and its files, as a site has them; 404 for
/// an unknown name.
[[nodiscard]] Response answer_viewer(const RouteRequest& call);

/// GET /view/appearance.bin: materials and the sky, which are compiled into the program.
[[nodiscard]] Response answer_appearance(const RouteRequest& call);

/// GET /openapi.json: docs/openapi.json, which is compiled into the program.
[[nodiscard]] Response answer_open_api(const RouteRequest& call);

/// GET /healthz: 200 text, whether boxes can be made; 503. The state is public; the reason of a
/// failure may contain file names, and is sent only to clients with the token.
[[nodiscard]] Response answer_health(const Service& service, const RouteRequest& call);

/// GET /v2/cached/{level}: 200 JSON, the boxes of a level that are cached in memory and on disk;
/// 400, 404.
[[nodiscard]] Response answer_cached(Service& service, const RouteRequest& call);

/// GET /v2/stats: 200 JSON.
/// @param counts counts of the router
/// @param uptime_s uptime of the router
[[nodiscard]] Response answer_stats(Service& service, const RouteRequest& call,
                                    const RequestCounts& counts, double uptime_s);

/// GET /metrics: 200, the text format of Prometheus, version 0.0.4. The values are maintained
/// elsewhere and only formatted here.
[[nodiscard]] Response answer_metrics(Service& service, const RequestCounts& counts,
                                      double uptime_s);

/// place.json of the viewer at /view (docs/formats/site.md): this server as the source of boxes,
/// and first views of its world.
/// @throws as World::column()
[[nodiscard]] std::string view_place(Service& service);

/// The coarsest level that the viewer should request. Where coarse boxes are made from fine ones,
/// the coarsest box of an unprepared world takes as long as all of it: levels are left out then,
/// down to one of which a column is soon made from what is kept, unless there would be too many
/// columns.
/// @return a level of the world
/// @throws as World::column()
[[nodiscard]] int coarsest_for_viewer(Service& service);

/// GET /v2/world: 200 JSON, the description of the world and the address of its map; 304. The world
/// does not change while it is served, so the reply is made once. Immutable, thread-safe.
class WorldRoute {
public:
    /// @param edition edition of the world; "" = it has none
    WorldRoute(const voxel::WorldInfo& info, std::string edition);

    [[nodiscard]] Response answer(const Request& request) const;

private:
    const std::string m_edition;
    const std::string m_json;
    const std::string m_etag;
};

}  // namespace terravox::http
