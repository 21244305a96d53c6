#pragma once

#include <cstdint>

#include "common/voxel/box.hpp"
#include "raytracer/core/base/ray_state.hpp"

namespace terravox::walk {

/// A voxel that emits light.
struct LampVoxel {
    core::VoxelCoord voxel;  ///< of `level`
    int level = 0;
    voxel::VoxelAttr attr;

    /// Edge, level-0 voxels.
    [[nodiscard]] double edge() const noexcept {
        return static_cast<double>(std::int64_t{1} << level);
    }
    /// Level-0 voxels.
    [[nodiscard]] core::Vec3 middle() const noexcept {
        const double size = edge();
        return {(voxel.x + 0.5) * size, (voxel.y + 0.5) * size, (voxel.z + 0.5) * size};
    }
};

/// A lamp that was chosen for a point.
struct LampChoice {
    LampVoxel lamp;
    float probability = 0;  ///< of the choice; 0: none was chosen
    /// Whether lamps near the point are sampled. They are not where there are very many: their
    /// light is met by chance.
    bool looked = false;
};

}  // namespace terravox::walk
