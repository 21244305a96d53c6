#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <vector>

#include "raytracer/blocks/block_manager.hpp"
#include "raytracer/farm/checkpoint/checkpoint.hpp"
#include "raytracer/output/film.hpp"
#include "raytracer/processors/processor.hpp"
#include "raytracer/shade/view.hpp"

namespace terravox::render {

struct RenderCounts {
    tiles::TraceCounts trace;
    std::uint64_t tiles = 0;
    std::uint32_t samples = 0;      ///< of a pixel at most
    std::set<voxel::BoxKey> holes;  ///< boxes that rays needed and that could not be had
    std::uint64_t resumed = 0;      ///< tiles that were done before
    std::uint64_t missing = 0;      ///< tiles that nobody was left to render
};

/// Everything about rendering that does not change while it runs.
struct RenderJob {
    const shade::View& view;
    processors::TileProcessor& processor;
    bool quiet = false;
    std::stop_token stop;  ///< ends the picture early
    std::function<void(std::uint64_t done, std::uint64_t of)> on_progress = {};  ///< tiles
    std::function<std::vector<std::string>()> details = {};  ///< lines to show below the progress
    farm::Checkpoint* checkpoint = nullptr;  ///< of a single pass: what is in it is not rendered
                                             ///< again, what is finished goes into it
    std::optional<farm::Part> part = {};     ///< only these tiles
    std::function<void()> check_world =
        {};  ///< throws once tiles may no longer be taken (BlockManager::check_world)
    std::function<std::vector<std::string>()> damage =
        {};  ///< of the world's data, for the checkpoint
    std::chrono::steady_clock::time_point start =
        std::chrono::steady_clock::now();  ///< from which Scene::quality.time_s counts
};

/// The passes of a picture through a processor into a film.
/// @throws Error "interrupted" when asked to stop, and as check_world; PictureInvalidated when a
/// tile came again for which the film has no place; whatever a tile threw
[[nodiscard]] RenderCounts render_film(const RenderJob& job, output::Film& film);

/// The same in a single pass, to where tiles go that are not kept: for pictures larger than memory.
/// The time to keep (quality.time_s) needs a film.
[[nodiscard]] RenderCounts render_stream(const RenderJob& job, output::TileSink& sink);

/// Whether a picture would show nothing of the world: no box is in sight, or what the camera looks
/// at lies farther from the world than the world is wide.
/// @return a line that says where the view is and where the world; empty: all is well
[[nodiscard]] std::string out_of_sight(const shade::View& view, const voxel::WorldInfo& world);

/// Begins to load what the view may see, nearest first.
void prefetch_visible(const shade::View& view, blocks::BlockManager& blocks);

}  // namespace terravox::render
