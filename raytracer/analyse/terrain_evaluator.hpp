#pragma once

#include "raytracer/shade/shading.hpp"

namespace terravox::analyse {

/// Measures core::TerrainBand: one ray down through the middle of each cell, and on to the ground.
class TerrainEvaluator final : public shade::RayEvaluator {
public:
    explicit TerrainEvaluator(const shade::View& view) noexcept : m_view(view) {}

    [[nodiscard]] walk::TracedRay primary(const core::Ray& ray,
                                          std::uint32_t sample) const noexcept override;
    [[nodiscard]] bool needs_surroundings(const walk::TracedRay& ray) const noexcept override;
    void shade(const walk::TracedRay& ray, shade::SampleSum& sum,
               std::vector<walk::TracedRay>& next) const override;

private:
    void note_surface(const walk::Hit& hit, core::Bands& bands) const noexcept;
    const shade::View& m_view;
};

}  // namespace terravox::analyse
