#pragma once

#include <cstddef>
#include <vector>

#include "common/voxel/world.hpp"
#include "raytracer/scene/scene.hpp"

namespace terravox::bench {

/// What boxes of one size cost.
struct BoxSize {
    int edge_voxels = 0;
    std::size_t boxes = 0;
    double tree_bytes = 0;
    double steps = 0;            ///< cells and voxels visited, a ray
    std::vector<double> make_s;  ///< making the trees of all boxes, each round
    std::vector<double> walk_s;  ///< a ray for each pixel, and one to the sun from what it meets
};

/// The paper's figure 6: one picture's rays through the same voxels in boxes of 16, 64 and 256
/// voxels a side (CubeTrees), on one thread. Whatever the size, rays end where those of the program
/// do.
/// @param scene with a camera; its voxels are those of level 0 throughout
/// @throws Error where a ray ends elsewhere
[[nodiscard]] std::vector<BoxSize> measure_box_sizes(voxel::World& world, const scene::Scene& scene,
                                                     int rounds);

}  // namespace terravox::bench
