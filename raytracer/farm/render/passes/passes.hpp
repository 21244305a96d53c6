#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <vector>

#include "raytracer/core/blocks/block_manager.hpp"
#include "raytracer/core/output/picture.hpp"
#include "raytracer/core/scene/camera.hpp"
#include "raytracer/core/shade/view.hpp"
#include "raytracer/core/walk/level_cut.hpp"
#include "raytracer/farm/checkpoint/checkpoint.hpp"
#include "raytracer/farm/processors/processor.hpp"

namespace terravox::render {

/// The boxes of a cut that may be in a camera's view, occluded or not, nearest first.
/// @param width_px, height_px of the picture
/// @param max greatest number of boxes returned
[[nodiscard]] std::vector<voxel::BoxKey> boxes_in_sight(const scene::Camera& camera, int width_px,
                                                        int height_px, const walk::LevelCut& cut,
                                                        std::size_t max);

struct RenderCounts {
    tiles::TraceCounts trace;
    std::uint64_t tiles = 0;
    std::uint32_t samples = 0;      ///< greatest number per pixel
    std::set<voxel::BoxKey> holes;  ///< boxes that rays needed and that were not available
    std::uint64_t resumed = 0;      ///< tiles restored from the checkpoint
    std::uint64_t missing = 0;      ///< tiles that no processor was left to render

    /// Those of another picture of the same report.
    void add(const RenderCounts& other);
    /// Those of a tile that was rendered before.
    void add(const tiles::TileResult& tile);
};

/// Everything about rendering that does not change while it runs.
struct RenderJob {
    const shade::View& view;
    processors::TileProcessor& processor;
    bool quiet = false;
    std::stop_token stop;  ///< ends the picture early
    std::function<void(std::uint64_t done, std::uint64_t of)> on_progress = {};  ///< tiles
    std::function<std::vector<std::string>()> details = {};  ///< lines to show below the progress
    /// For a single pass: its tiles are not rendered again, and finished ones are added.
    farm::Checkpoint* checkpoint = nullptr;
    std::optional<farm::Part> part = {};  ///< only these tiles
    /// Throws once tiles may no longer be accepted (BlockManager::check_world).
    std::function<void()> check_world = {};
    /// Returns the damage of the world's data, for the checkpoint.
    std::function<std::vector<std::string>()> damage = {};
    /// Time from which Scene::quality.time_s counts.
    std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
};

/// Renders the passes of a picture with a processor into a film.
/// @throws Error "interrupted" when stopped, and as check_world; PictureInvalidated when a tile was
/// delivered again and the film cannot replace it; whatever a tile threw
[[nodiscard]] RenderCounts render_film(const RenderJob& job, output::Film& film);

/// The same in a single pass into a sink that does not keep tiles: for pictures larger than memory.
/// A time limit (quality.time_s) needs a film.
[[nodiscard]] RenderCounts render_stream(const RenderJob& job, output::TileSink& sink);

/// Whether a picture would show nothing of the world: no box is in sight, or the point that the
/// camera looks at is farther from the world than the world is wide.
/// @return a message with the positions of the view and of the world; empty if the world is in
/// sight
[[nodiscard]] std::string out_of_sight(const shade::View& view, const voxel::WorldInfo& world);

/// Begins to load the boxes that may be visible, nearest first.
void prefetch_visible(const shade::View& view, blocks::BlockManager& blocks);

}  // namespace terravox::render
