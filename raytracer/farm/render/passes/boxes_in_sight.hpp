#pragma once

#include <vector>

#include "raytracer/core/scene/camera.hpp"
#include "raytracer/core/walk/level_cut.hpp"

namespace terravox::render {

/// The boxes of a cut that may be in a camera's view, occluded or not, nearest first.
/// @param width_px, height_px of the picture
/// @param max greatest number of boxes returned
[[nodiscard]] std::vector<voxel::BoxKey> boxes_in_sight(const scene::Camera& camera, int width_px,
                                                        int height_px, const walk::LevelCut& cut,
                                                        std::size_t max);

}  // namespace terravox::render
