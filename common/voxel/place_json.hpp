#pragma once

#include <nlohmann/json.hpp>

#include "common/geo/lat_lon.hpp"

namespace terravox::voxel {

/// {"lat_deg", "lon_deg", "convergence_deg"}
[[nodiscard]] nlohmann::json place_to_json(const geo::MapPlace& place);

/// @param json as place_to_json() writes it; without "convergence_deg", as older programs wrote it,
/// the map's north counts as true north
/// @throws nlohmann::json::exception for a member that is missing or of another type
/// @throws Error naming a value beyond -90 to 90, or -360 to 360 degrees
[[nodiscard]] geo::MapPlace place_from_json(const nlohmann::json& json);

}  // namespace terravox::voxel
