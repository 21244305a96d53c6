#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/bench/accuracy/errors.hpp"
#include "voxelserver/voxelize/world/lidar_world.hpp"

namespace terravox::bench {

/// A ground point that is withheld from the voxelizer; file coordinates, height in metres.
struct HeldOut {
    double x = 0;
    double y = 0;
    double height_m = 0;
};

/// Copies LAS or LAZ files into a folder without every `nth` ground point (class 2), counted over
/// all files in their order. Coordinates, classes, returns and colours are kept, flags and the rest
/// are not; CRS is left to the options of the world. @throws Error
[[nodiscard]] std::vector<HeldOut> hold_out_ground(const std::vector<std::filesystem::path>& files,
                                                   const std::filesystem::path& folder, int nth);

/// Predicted minus true heights, the prediction bilinear between the centres of the four columns
/// around a point. Points next to a column without ground are left out and counted. @param without
/// receives how many those are
[[nodiscard]] Errors predict_held_out(voxelize::LidarWorld& world,
                                      const std::vector<HeldOut>& points, std::size_t& without);

}  // namespace terravox::bench
