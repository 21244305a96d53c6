#pragma once

#include "raytracer/shade/shading.hpp"

namespace terravox {

/// The paper's set of rays: sun with shadows, the sky's light less what stands around (corners
/// without rays, or ambient-occlusion rays), mirrors, and what lies in water.
class DirectShading final : public Shading {
public:
    using Shading::Shading;
    [[nodiscard]] bool needs_surroundings(const TracedRay& ray) const noexcept override;

private:
    void light_up(const Meeting& m) const override;
    void leave(const TracedRay& ray, Colour weight, SampleSum& sum) const override;
    [[nodiscard]] bool splits(const TracedRay& ray) const noexcept override {
        return ray.depth == 0;
    }
    void send_ambient(const Meeting& m, Colour light) const;
};

}  // namespace terravox
