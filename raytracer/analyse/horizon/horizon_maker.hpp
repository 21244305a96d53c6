#pragma once

#include <filesystem>

#include "common/voxel/world.hpp"
#include "raytracer/core/scene/scene.hpp"

namespace terravox::analyse {

/// Terrain outside of the data, and how far it is looked at.
struct HorizonSource {
    std::filesystem::path file;  ///< raster of heights above the same sea level as the data's
    double range_m = 60'000;     ///< from the border of the data
};

/// Puts the terrain outside of the data into a scene (solar::FarHorizon), so that it hides sun and
/// sky. Points are up to 250 m apart, at most 9 by 9 across the data; of each, the raster is
/// followed in 360 azimuths, from a cell beyond the border of the data on, in steps of a cell or of
/// half a percent of the distance. Rays bend with the air (coefficient of refraction 0.13).
/// @param[in,out] scene of an analysis
/// @throws UsageError for a world without a CRS; Error as FarHeights, and where no height lies
/// outside of the data
void look_at_horizon(const HorizonSource& source, const voxel::WorldInfo& world,
                     scene::Scene& scene);

}  // namespace terravox::analyse
