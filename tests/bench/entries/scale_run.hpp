#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "raytracer/output/film.hpp"
#include "raytracer/scene/scene.hpp"
#include "tests/bench/bench.hpp"
#include "tests/bench/entries/scale_world.hpp"

namespace terravox::bench {

/// Boxes are kept in $TERRAVOX_BENCH_CACHE from run to run, or else in the scratch folder.
[[nodiscard]] std::shared_ptr<ScaleWorld> open_scale_world(const Context& context, int side_km);
/// Keeps all boxes and reports its progress on standard error. @param readings takes the costs and
/// the sizes of boxes; may be nullptr
void prepare_scale_world(ScaleWorld& world, int threads, Readings* readings);

/// A view of the synthetic land, the same whatever the size of the world around it: 1280x720, one
/// sample a pixel.
struct ScaleView {
    const char* name;
    scene::Scene scene;
    bool fills_smallest =
        true;  ///< shows land even in the smallest world, so that its time is meaningful
};
/// "high": from 600 m above the middle to the horizon. "oblique": from 300 m above the edge of the
/// middle square kilometre across it to the horizon, so that half of its picture is land at any
/// size. "ground": 2 m above a shore, along a valley with a lake.
[[nodiscard]] std::vector<ScaleView> scale_views();

struct Shot {
    output::Film film;
    double seconds = 0;
    double cpu_s = 0;
    double megarays = 0;
    double peak_boxes_mib = 0;               ///< of boxes in memory
    double peak_mib = 0;                     ///< memory of the process while it rendered
    std::uint64_t boxes = 0, hole_rays = 0;  ///< boxes requested from the world
    double boxes_mib = 0;
};
/// One picture from a cold memory. The only function of this benchmark that renders pictures.
/// @throws Error
[[nodiscard]] Shot shoot(voxel::World& world, const scene::Scene& scene, std::size_t memory_bytes,
                         int threads);

/// Mean absolute difference of linear light, as a share of the reference's mean, percent.
[[nodiscard]] double difference_percent(const output::Film& film, const output::Film& reference);
/// Pixels that are not the same to the last bit.
[[nodiscard]] std::size_t pixels_unlike(const output::Film& film, const output::Film& reference);

/// Writes "name.png" to $TERRAVOX_BENCH_CACHE/pictures, for visual checks; without the
/// variable it does nothing.
void keep_picture(const output::Film& film, const std::string& name);

}  // namespace terravox::bench
