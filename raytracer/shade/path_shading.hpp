#pragma once

#include "raytracer/shade/shading.hpp"

namespace terravox::shade {

/// Path tracing: each face continues the path in one random direction; the sun is sampled directly,
/// the sky both directly and by the path. Ref: Kajiya, "The Rendering Equation", SIGGRAPH 1986;
/// Veach & Guibas, "Optimally Combining Sampling Techniques", SIGGRAPH 1995 (balance heuristic).
class PathShading : public Shading {
public:
    using Shading::Shading;
    [[nodiscard]] bool needs_surroundings(const walk::TracedRay& ray) const noexcept override;

protected:
    void shade_opaque(const Interaction& m) const override;
    void miss(const walk::TracedRay& ray, voxel::Colour weight, SampleSum& sum) const override;
    [[nodiscard]] bool splits(const walk::TracedRay&) const noexcept override { return false; }
    /// Sends the mirrored ray of a smooth coat, by its share of chance.
    /// @return whether the path goes on that way, or ends there
    [[nodiscard]] bool takes_mirror(const Interaction& m) const;

private:
    void send_sky(const Interaction& m, voxel::Colour weight) const;
    void send_even_sky(const Interaction& m, voxel::Colour weight) const;
    void bounce(const Interaction& m, voxel::Colour weight) const;
};

}  // namespace terravox::shade
