#pragma once

#include "raytracer/analyse/cell_evaluator.hpp"

namespace terravox::analyse {

/// Measures the sun's bands (core::SunBand and others, by the kind): from the middle of each cell's
/// top, or of its ground, a ray in each direction of the view's sun way. Whatever blocks it puts
/// the cell into shadow for all of the direction's time.
class SunEvaluator final : public CellEvaluator {
public:
    explicit SunEvaluator(const shade::View& view) noexcept : m_view(view) {}

    void shade(const walk::TracedRay& ray, shade::SampleSum& sum,
               std::vector<walk::TracedRay>& next) const override;

private:
    void shade_cell(const walk::TracedRay& ray, shade::SampleSum& sum,
                    std::vector<walk::TracedRay>& next) const;
    [[nodiscard]] core::Bands without_sun() const noexcept;
    void add_sunlit(const solar::SunDirection& from, core::Bands& bands) const noexcept;
    /// Sends the chunk of rays that begins with direction `first`.
    void send_to_sun(const walk::TracedRay& ray, std::size_t first,
                     std::vector<walk::TracedRay>& next) const;
    const shade::View& m_view;
};

}  // namespace terravox::analyse
