#pragma once

#include <filesystem>
#include <memory>
#include <utility>
#include <vector>

#include "tests/voxelserver/make/worlds/voxels.hpp"
#include "voxelserver/make/worlds/heightmap/heightmap_world.hpp"

namespace terravox::test {

inline std::unique_ptr<voxel::World> open(std::vector<std::filesystem::path> rasters,
                                          double voxel_m = 1) {
    heightmap::HeightmapOptions options;
    options.rasters = std::move(rasters);
    options.voxel_m = voxel_m;
    return heightmap::open_heightmap_world(options);
}

}  // namespace terravox::test
