#pragma once

#include "raytracer/analyse/evaluators/column_descent.hpp"
#include "raytracer/core/shade/shading.hpp"

namespace terravox::analyse {

/// Measures cells, each from one vertical ray through its middle.
class CellEvaluator : public shade::RayEvaluator {
public:
    [[nodiscard]] walk::TracedRay primary(const core::Ray& ray,
                                          std::uint32_t sample) const noexcept override {
        return cell_ray(ray, sample);
    }
    [[nodiscard]] bool needs_surroundings(const walk::TracedRay& /*ray*/) const noexcept final {
        return false;
    }
};

}  // namespace terravox::analyse
