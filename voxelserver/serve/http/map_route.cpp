#include "voxelserver/serve/http/map_route.hpp"

#include <xxhash.h>

#include "voxelserver/serve/http/map_view.hpp"

namespace terravox::http {

Response answer_map_tile(Service& service, const RouteRequest& call) {
    constexpr std::string_view kEnding = ".png";
    const auto& part = call.parts.part;
    const auto z = parse_int32(part[1]);
    const auto x = parse_int32(part[2]);
    const auto y = parse_int32(part[3].substr(0, part[3].size() - kEnding.size()));
    if (!z || !x || !y)
        return not_numbers(call.request);
    if (service.map == nullptr)
        return problem(404, "this server has no map");
    map::Tile tile;
    try {
        tile = service.map->get(*z, *x, *y);
    } catch (const util::UsageError& e) {
        return problem(404, e.what());
    }
    const auto& png = tile.png ? tile.png : MapView::empty_tile();
    Response out;
    if (tile.complete) {
        const std::string etag = etag_of(XXH64(png->data(), png->size(), 0), "m");
        if (etag_matches(call.request.header("If-None-Match"), etag))
            return not_modified(etag);
        add_validators(out, etag);
    } else {
        out.add("Cache-Control", "no-store");
    }
    out.add("Content-Type", "image/png").add("Terravox-Complete", tile.complete ? "yes" : "no");
    out.body = png;
    return out;
}

}  // namespace terravox::http
