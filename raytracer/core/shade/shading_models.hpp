#pragma once

#include "raytracer/core/shade/shading.hpp"

namespace terravox::shade {

/// The paper's set of rays: sun with shadows, the sky's light less what the surroundings occlude
/// (darkened corners without rays, or ambient-occlusion rays), mirrors, and what lies in water.
class DirectShading final : public Shading {
public:
    using Shading::Shading;
    [[nodiscard]] bool needs_surroundings(const walk::TracedRay& ray) const noexcept override;

private:
    void shade_opaque(const Interaction& m) const override;
    void miss(const walk::TracedRay& ray, voxel::Colour weight, SampleSum& sum) const override;
    [[nodiscard]] bool splits(const walk::TracedRay& ray) const noexcept override {
        return ray.depth == 0;
    }
    void send_ambient(const Interaction& m, voxel::Colour light) const;
};

/// Path tracing: each face continues the path in one random direction; the sun is sampled directly,
/// the sky both directly and by the path. Ref: Kajiya, "The Rendering Equation", SIGGRAPH 1986;
/// Veach & Guibas, "Optimally Combining Sampling Techniques", SIGGRAPH 1995 (balance heuristic).
class PathShading final : public Shading {
public:
    using Shading::Shading;
    [[nodiscard]] bool needs_surroundings(const walk::TracedRay& ray) const noexcept override;

private:
    void shade_opaque(const Interaction& m) const override;
    void miss(const walk::TracedRay& ray, voxel::Colour weight, SampleSum& sum) const override;
    [[nodiscard]] bool splits(const walk::TracedRay&) const noexcept override { return false; }
    /// Random numbers for the look at the sky, or the bounce, at a face.
    [[nodiscard]] static Sampler::Pair direction_numbers(const Interaction& m,
                                                         std::uint32_t use) noexcept;
    void send_sky(const Interaction& m, voxel::Colour weight) const;
    void send_even_sky(const Interaction& m, voxel::Colour weight) const;
    void bounce(const Interaction& m, voxel::Colour weight) const;
};

}  // namespace terravox::shade
