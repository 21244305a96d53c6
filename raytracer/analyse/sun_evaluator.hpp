#pragma once

#include "raytracer/shade/shading.hpp"

namespace terravox::analyse {

/// Measures core::SunBand: from the middle of each cell's top, or of its ground, a ray towards each
/// of the view's sun steps. Whatever blocks it puts the cell into shadow for the whole step.
class SunEvaluator final : public shade::RayEvaluator {
public:
    explicit SunEvaluator(const shade::View& view) noexcept : m_view(view) {}

    [[nodiscard]] walk::TracedRay primary(const core::Ray& ray,
                                          std::uint32_t sample) const noexcept override;
    [[nodiscard]] bool needs_surroundings(const walk::TracedRay& ray) const noexcept override;
    void shade(const walk::TracedRay& ray, shade::SampleSum& sum,
               std::vector<walk::TracedRay>& next) const override;

private:
    void add_sunlit_step(std::size_t step, core::Bands& bands) const noexcept;
    void send_to_sun(const walk::TracedRay& ray, shade::SampleSum& sum,
                     std::vector<walk::TracedRay>& next) const;
    const shade::View& m_view;
};

}  // namespace terravox::analyse
