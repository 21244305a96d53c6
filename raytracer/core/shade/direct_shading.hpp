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

}  // namespace terravox::shade
