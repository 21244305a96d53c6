#pragma once

#include <string>

#include "tests/bench/entries/light_picture.hpp"
#include "tests/bench/entries/neutral_scene.hpp"

namespace terravox::bench {

/// The light of light/cycles and light/cached: the voxels of trace/neutral, all of one grey, under
/// a sun and an even sky.
struct NeutralLight {
    static constexpr int kBounces = 3;
    static constexpr float kGrey = 0.8f;
    static constexpr std::array<double, 3> kSky = {0.5, 0.7, 1};
    /// A sun lamp's strength is the irradiance of what faces it; a white surface sends 1 / pi of
    /// that.
    static constexpr double kSunIrradiance = 3;
    static constexpr double kSunRadius_deg = 0.2666;

    /// All boxes are loaded.
    explicit NeutralLight(const Context& c);
    /// A picture of a view by paths; integrator and samples are the caller's to change.
    [[nodiscard]] static scene::Scene scene_of(const NeutralView& view, int samples);
    [[nodiscard]] TracedPicture trace(const scene::Scene& picture, int threads);

    NeutralScene scene;
    NeutralWorld world;
    blocks::BlockManager blocks;
};

/// How many rays of each kind there were for each primary ray, as a sentence.
[[nodiscard]] std::string rays_of(const std::string& name, const render::RenderCounts& counts);

}  // namespace terravox::bench
