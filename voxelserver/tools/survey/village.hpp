#pragma once

#include <vector>

#include "voxelserver/tools/survey/building.hpp"
#include "voxelserver/tools/survey/roads.hpp"
#include "voxelserver/tools/survey/terrain.hpp"

namespace terravox::survey {

/// All buildings of a site: castle, churches, hotels, the houses along its streets, and the
/// balconies and carports at some of them. No two overlap, except parts of one landmark; none
/// stands on a road or in water. A function of seed and site only.
/// @param terrain made for an area that holds the site, or for one no farther than kSiteReach_m
/// from its centre
[[nodiscard]] std::vector<Building> build_village(const Terrain& terrain, const Site& site);

/// The landmarks alone. They come first in build_village.
[[nodiscard]] std::vector<Building> build_landmarks(const Terrain& terrain, const Site& site);

}  // namespace terravox::survey
