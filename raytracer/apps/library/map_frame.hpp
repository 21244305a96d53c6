#pragma once

#include <terravox/place.hpp>

#include "common/voxel/world.hpp"
#include "raytracer/core/base/ray.hpp"

namespace terravox {

/// Between the coordinates of a map and voxels of level 0 (terravox/place.hpp).
class MapFrame {
public:
    explicit MapFrame(const voxel::WorldInfo& world) noexcept
        : m_units(world.crs.empty() ? world.voxel_m : world.crs_units_per_voxel),
          m_voxel_m(world.voxel_m) {}

    /// A point or a direction: both systems have the same origin.
    [[nodiscard]] core::Vec3 to_voxels(const double (&at)[3]) const noexcept {
        return {at[0] / m_units, at[2] / m_voxel_m, -at[1] / m_units};
    }
    [[nodiscard]] double units() const noexcept { return m_units; }
    [[nodiscard]] MapBounds bounds_of(const voxel::VoxelBounds& block) const noexcept {
        return {block.min[0] * m_units,  -block.max[2] * m_units,  block.max[0] * m_units,
                -block.min[2] * m_units, block.min[1] * m_voxel_m, block.max[1] * m_voxel_m};
    }
    /// The smallest block of voxels of a level that covers bounds, as far as it is in a world, in
    /// voxels of that level.
    /// @throws util::UsageError where nothing is left
    [[nodiscard]] voxel::VoxelBounds block_over(const MapBounds& bounds, int level,
                                                const voxel::VoxelBounds& world) const;

private:
    double m_units;
    double m_voxel_m;
};

}  // namespace terravox
