#pragma once

#include "voxelserver/serve/http/service.hpp"

namespace terravox::http {

/// GET /map/{z}/{x}/{y}.png: 200 a tile of the top view (voxelserver/serve/map/map_tiles.hpp), 304,
/// 400, 404 no such zoom, 500, 503. An incomplete tile has the header `Terravox-Complete: no` and
/// must not be cached.
[[nodiscard]] Response answer_map_tile(Service& service, const RouteRequest& call);

}  // namespace terravox::http
