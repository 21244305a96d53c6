#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "common/util/stage_times.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/http/box_replies.hpp"
#include "voxelserver/http/message.hpp"
#include "voxelserver/http/request_counts.hpp"

namespace terravox::http {

/// Answers requests about one world: a function of the request, without sockets. Thread-safe.
///
/// GET and HEAD; other methods: 405. A request with a body: 413, and the connection is to be closed.
///   /                               200 a page (HTML)
///   /healthz                        200 "ok"
///   /v2/world                       200 JSON, 304
///   /v2/boxes/{level}/{bx}/{by}/{bz} 200 a zstd frame of the box, 204 air, 304, 400 not 32-bit integers, 404 no such level,
///                                   500 the box cannot be made, 503 (Retry-After) too many are being made
///   /v2/columns/{level}/{bx}/{bz}   200 JSON, 400, 404, 500. by_begin, by_end: half-open, boxes of that level, equal for air;
///                                   min_y, max_y: the same in voxels of level 0, cut to the bounds of the world
///   /v2/stats                       200 JSON
/// Errors are application/problem+json.
class Router {
public:
    /// World and times must outlive the router.
    Router(voxel::World& world, util::StageTimes& times, const BoxRepliesOptions& options);

    /// What handling throws becomes a reply with status 500. @throws only when there is no memory even for that
    [[nodiscard]] Response handle(const Request& request);

    [[nodiscard]] RequestCounts& counts() noexcept { return m_counts; }

private:
    using Parts = std::vector<std::string_view>;
    [[nodiscard]] Response answer(Route route, const Parts& parts, const Request& request);
    [[nodiscard]] Response dispatch(Route route, const Parts& parts, const Request& request);
    [[nodiscard]] Response world(const Request& request) const;
    [[nodiscard]] Response box(const Parts& parts, const Request& request);
    [[nodiscard]] Response column(const Parts& parts, const Request& request);
    [[nodiscard]] Response stats() const;
    [[nodiscard]] Response no_such_level(int level) const;

    voxel::World& m_world;
    util::StageTimes& m_times;
    BoxReplies m_boxes;
    RequestCounts m_counts;
    const std::chrono::steady_clock::time_point m_start = std::chrono::steady_clock::now();
    const std::string m_world_json, m_world_etag;
};

}  // namespace terravox::http
