#pragma once

#include "raytracer/analyse/evaluators/cell_evaluator.hpp"

namespace terravox::analyse {

/// Measures core::TerrainBand: one ray down through the middle of each cell, and on to the ground.
class TerrainEvaluator final : public CellEvaluator {
public:
    explicit TerrainEvaluator(const shade::View& view) noexcept : m_view(view) {}

    void shade(const walk::TracedRay& ray, shade::SampleSum& sum,
               std::vector<walk::TracedRay>& next) const override;

private:
    void note_surface(const walk::Hit& hit, core::Bands& bands) const noexcept;
    const shade::View& m_view;
};

}  // namespace terravox::analyse
