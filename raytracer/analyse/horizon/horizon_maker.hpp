#pragma once

#include <cmath>
#include <filesystem>
#include <vector>

#include "common/voxel/world.hpp"
#include "raytracer/analyse/solar/far_horizon.hpp"
#include "raytracer/core/scene/scene.hpp"

namespace terravox::analyse {

/// The tops of a line of terrain that some slope of rays needs: the upper left part of its convex
/// hull, from the first place to the highest one. Built from the near end to the far end.
class Skyline {
public:
    /// Adds a place.
    /// @param distance_m above that of the place before
    /// @param height_m above the sea, lowered by the Earth's curvature
    void add(double distance_m, double height_m);
    /// Height of the highest place so far; below all heights where there is none.
    [[nodiscard]] double highest_m() const noexcept {
        return m_places.empty() ? -HUGE_VAL : m_places.back().height_m;
    }
    /// The tops in whole metres, the farthest one last. Left out are those that lift the line by
    /// less than half a metre, and those that lift it least where there are more than
    /// FarHorizon::kMaxTops.
    [[nodiscard]] solar::FarHorizon::Tops tops() const;

private:
    struct Place {
        double distance_m = 0;
        double height_m = 0;
    };
    /// How far a place is above the straight line between two others.
    [[nodiscard]] static double lift(const Place& before, const Place& at, const Place& after);

    std::vector<Place> m_places;
};

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
