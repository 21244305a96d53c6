#pragma once

#include "voxelserver/serve/http/service.hpp"

namespace terravox::http {

/// GET /v2/boxes/{level}/{bx}/{by}/{bz}: 200 the box, zstd or uncompressed; 204 air, 304, 400, 404,
/// 406, 500, 503.
[[nodiscard]] Response answer_box(Service& service, const RouteRequest& call);

/// GET /v2/columns/{level}/{bx}/{bz}: 200 JSON, 400, 404, 500. by_begin, by_end: half-open, boxes
/// of that level, equal for air; min_y, max_y: the same in voxels of level 0, clipped to the bounds
/// of the world.
[[nodiscard]] Response answer_column(Service& service, const RouteRequest& call);

}  // namespace terravox::http
