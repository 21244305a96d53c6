#pragma once

#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "raytracer/render/passes/passes.hpp"
#include "tests/bench/clocks.hpp"

namespace terravox::bench {

/// A picture in linear light, for comparison with other renderers: r, g, b of each pixel, rows from
/// the top.
struct LinearPicture {
    int width_px = 0;
    int height_px = 0;
    std::vector<float> rgb;
};
[[nodiscard]] LinearPicture picture_of(const output::Film& film);
/// Raw float32 in the machine's order. @throws Error when the file has not the size of such a
/// picture, or a number is not finite
[[nodiscard]] LinearPicture read_picture(const std::filesystem::path& file, int width_px,
                                         int height_px);
void write_picture(const std::filesystem::path& file,
                   const LinearPicture& picture);  ///< @throws Error

[[nodiscard]] double mean_of(
    const LinearPicture& picture) noexcept;  ///< over all pixels and channels
/// Root of the mean squared difference over all pixels and channels of two pictures of one size.
[[nodiscard]] double rms_difference(const LinearPicture& a, const LinearPicture& b);
/// The noise of one of two pictures that differ in their seed alone.
[[nodiscard]] double noise_of(const LinearPicture& one, const LinearPicture& other);

/// A picture as the program makes it, without files, and what it took.
struct TracedPicture {
    LinearPicture picture;
    Cost cost;
    render::RenderCounts counts;
};
/// In a single pass. @throws Error when a ray met a hole
[[nodiscard]] TracedPicture trace_picture(const shade::View& view, blocks::BlockManager& blocks,
                                          int threads);

/// All materials the same: matt, of one grey, without drawings. @param albedo linear, [0, 1]
[[nodiscard]] std::shared_ptr<const material::MaterialTable> grey_materials(float albedo);

/// A direction to the sun as a scene states it.
void set_sun(scene::Scene& scene, core::Vec3 to_sun);

/// A script of tests/bench/light by its whole path.
[[nodiscard]] std::string light_script(const std::string& file);
/// Runs a program that leaves its figures in a file. @throws Error with its last line when it
/// fails, or leaves none
[[nodiscard]] nlohmann::json figures_of(const Context& context,
                                        const std::vector<std::string>& command,
                                        const std::filesystem::path& figures);

}  // namespace terravox::bench
