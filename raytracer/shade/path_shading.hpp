#pragma once

#include "raytracer/shade/shading.hpp"

namespace terravox {

/// Path tracing: from each face one way on by chance, the sun asked for directly, the sky both
/// ways. Ref: Kajiya, "The Rendering Equation", SIGGRAPH 1986; Veach & Guibas, "Optimally Combining
/// Sampling Techniques", SIGGRAPH 1995 (balance heuristic).
class PathShading final : public Shading {
public:
    using Shading::Shading;
    [[nodiscard]] bool needs_surroundings(const TracedRay& ray) const noexcept override;

private:
    void light_up(const Meeting& m) const override;
    void leave(const TracedRay& ray, Colour weight, SampleSum& sum) const override;
    [[nodiscard]] bool splits(const TracedRay&) const noexcept override { return false; }
    void send_sky(const Meeting& m, Colour weight) const;
    void send_even_sky(const Meeting& m, Colour weight) const;
    void bounce(const Meeting& m, Colour weight) const;
};

}  // namespace terravox
