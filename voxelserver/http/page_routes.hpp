#pragma once

#include "voxelserver/http/service.hpp"

namespace terravox::http {

/// GET / and /page/{name}: the page and its files, which are compiled into the program; 404 for an
/// unknown name.
[[nodiscard]] Response answer_page(const RouteRequest& call);

/// GET /openapi.json: docs/openapi.json, which is compiled into the program.
[[nodiscard]] Response answer_open_api(const RouteRequest& call);

}  // namespace terravox::http
