#pragma once

#include "voxelserver/http/service.hpp"

namespace terravox::http {

/// GET / and /page/{name}: the page and its files, which are part of the program; 404 for another
/// name.
[[nodiscard]] Response answer_page(const RouteRequest& asked);

/// GET /openapi.json: docs/openapi.json, which is part of the program.
[[nodiscard]] Response answer_open_api(const RouteRequest& asked);

}  // namespace terravox::http
