#pragma once

#include <string_view>

#include "voxelserver/serve/http/service.hpp"

namespace terravox::http {

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

}  // namespace terravox::http
