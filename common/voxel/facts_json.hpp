#pragma once

#include <nlohmann/json.hpp>

#include "common/voxel/world.hpp"

namespace terravox::voxel {

/// The members that every JSON file about a world has: version, program, title, place on Earth,
/// size of voxels, and terms of use.
[[nodiscard]] nlohmann::json facts_to_json(const WorldInfo& info, int version);

/// Reads them; other members of `into` stay.
/// @param json of a centre without "convergence_deg", as older programs wrote it, the map's north
/// counts as true north
/// @throws nlohmann::json::exception for a member that is missing or of another type
/// @throws Error naming a centre beyond -90 to 90, or -360 to 360 degrees
void read_facts(const nlohmann::json& json, WorldInfo& into);

}  // namespace terravox::voxel
