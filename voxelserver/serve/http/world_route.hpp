#pragma once

#include <string>

#include "voxelserver/serve/http/service.hpp"

namespace terravox::http {

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
