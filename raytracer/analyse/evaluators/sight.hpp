#pragma once

#include <cstdint>
#include <span>

#include "raytracer/analyse/evaluators/cell_evaluator.hpp"
#include "raytracer/core/base/ray.hpp"
#include "raytracer/core/blocks/block_manager.hpp"
#include "raytracer/core/scene/scene.hpp"

namespace terravox::analyse {

/// What an observer's height counts from.
enum class HeightBase : std::uint8_t {
    kZero,    ///< the heights of the world
    kTop,     ///< the top of the highest voxel: roof, crown, deck
    kGround,  ///< the ground, below crowns and decks
};

/// A point that looks, as a user gives it.
struct Observer {
    double x = 0;  ///< level-0 voxels
    double z = 0;  ///< level-0 voxels
    double height_m = 0;
    HeightBase base = HeightBase::kZero;
    std::string text;  ///< for messages
};

/// Finds where observers are, among the voxels that the scene's analysis uses. Blocks while boxes
/// are loaded.
/// @param scene its camera is that of the cells
/// @throws UsageError for one beyond the world or inside a voxel, and where there is nothing that
/// its height could count from; Error where that could not be read
[[nodiscard]] scene::PointList place_observers(std::span<const Observer> observers,
                                               const scene::Scene& scene,
                                               blocks::BlockManager& blocks);

}  // namespace terravox::analyse
