#include "voxelserver/serve/http/world_route.hpp"

#include <xxhash.h>

#include <nlohmann/json.hpp>

#include "common/voxel/world_json.hpp"
#include "voxelserver/serve/map/map_tiles.hpp"

namespace terravox::http {
namespace {

// The world in its JSON format, with the address of its map.
std::string world_text(const voxel::WorldInfo& info) {
    auto world = nlohmann::json::parse(voxel::world_to_json(info));
    world["map"] = {{"tile_px", map::kTilePx}, {"zooms", {0, info.levels - 1}}};
    return world.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace

WorldRoute::WorldRoute(const voxel::WorldInfo& info, std::string edition)
    : m_edition(std::move(edition)),
      m_json(world_text(info)),
      m_etag(etag_of(XXH64(m_json.data(), m_json.size(), 0), "w")) {}

Response WorldRoute::answer(const Request& request) const {
    if (etag_matches(request.header("If-None-Match"), m_etag))
        return not_modified(m_etag);
    Response out = reply(200, "application/json", m_json);
    add_validators(out, m_etag);
    if (!m_edition.empty())
        out.add(kEditionHeader, m_edition);
    return out;
}

}  // namespace terravox::http
