#pragma once

#include <filesystem>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "common/util/stage_times.hpp"
#include "raytracer/core/blocks/block_manager.hpp"
#include "raytracer/core/scene/scene.hpp"
#include "raytracer/farm/coordinator/worker_link.hpp"
#include "voxelserver/make/worlds/kind/world_options.hpp"

namespace terravox::render {

/// A world with its boxes in memory, and what it was opened from: for several pictures in sequence
/// or in parallel.
struct LoadedWorld {
    /// @param scene only world and processing are used
    /// @param stop as for open_world
    /// @throws Error, UsageError
    LoadedWorld(const worlds::WorldOptions& from, const scene::Scene& scene,
                const std::stop_token& stop = {});

    const std::vector<std::string> inputs;
    const std::vector<std::filesystem::path> orthophotos;
    const farm::BoxSource source;  ///< where workers may get boxes from
    util::StageTimes times;        ///< must outlive the world, which writes to it
    const std::unique_ptr<voxel::World> world;
    blocks::BlockManager blocks;
};

}  // namespace terravox::render
