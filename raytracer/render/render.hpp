#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "common/util/stage_times.hpp"
#include "raytracer/output/film.hpp"
#include "raytracer/output/image_writer.hpp"
#include "raytracer/sched/processor.hpp"

namespace terravox {

struct RenderCounts {
    std::uint64_t rays = 0, steps = 0, hole_rays = 0, tiles = 0;
};

/// Everything about rendering that does not change while it runs.
struct RenderJob {
    const View& view;
    TileProcessor& processor;
    int tiles_in_flight = 4;  ///< at least as many as the processor can work on at once
    bool quiet = false;
    const std::atomic<bool>* stop = nullptr;  ///< asks to end early
};

/// The passes of a picture through a processor into a film.
/// @throws Error "interrupted" when asked to stop; whatever a tile threw
[[nodiscard]] RenderCounts render_film(const RenderJob& job, Film& film);

/// The view that a scene gives of a world. @throws UsageError for a camera inside rock, a level the world does not have, ...
[[nodiscard]] View make_view(const Scene& scene, BlockManager& blocks);

/// What a person should know of a picture, stored in it.
[[nodiscard]] ImageMetadata metadata_of(const View& view, const voxel::WorldInfo& world, std::size_t holes);

}  // namespace terravox
