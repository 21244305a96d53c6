#pragma once

#include "voxelserver/serve/http/service.hpp"

namespace terravox::http {

/// GET /gkot/box?...: the first system's reply (docs/formats/http.md); 400 for a parameter that is
/// missing, repeated or out of range, 413 for more voxels than the memory allows, 500, 503.
[[nodiscard]] Response answer_gkot_box(Service& service, const RouteRequest& call);

/// GET /gkot/origin.json?tmx&tmy: 200 JSON, 400.
[[nodiscard]] Response answer_gkot_origin(Service& service, const RouteRequest& call);

}  // namespace terravox::http
