#pragma once

#include "raytracer/analyse/evaluators/cell_evaluator.hpp"
#include "raytracer/analyse/evaluators/sight_line.hpp"

namespace terravox::analyse {

/// Measures core::SightBand: from above the middle of each cell's top, or of its ground, a line of
/// sight to each of the scene's observers. A voxel of any material blocks it, leaves and panes as
/// well.
class SightEvaluator final : public CellEvaluator {
public:
    explicit SightEvaluator(const shade::View& view);

    void shade(const walk::TracedRay& ray, shade::SampleSum& sum,
               std::vector<walk::TracedRay>& next) const override;

private:
    void shade_cell(const walk::TracedRay& ray, shade::SampleSum& sum,
                    std::vector<walk::TracedRay>& next) const;
    void send_to_observers(const walk::TracedRay& ray, shade::SampleSum& sum,
                           std::vector<walk::TracedRay>& next) const;
    void arrive(const walk::TracedRay& ray, shade::SampleSum& sum,
                std::vector<walk::TracedRay>& next) const;
    [[nodiscard]] SightLine line_to(std::size_t observer, core::Vec3 target) const noexcept;
    [[nodiscard]] walk::TracedRay along(const SightLine& line, std::size_t observer,
                                        std::uint32_t chord, std::uint32_t sample) const noexcept;

    const shade::View& m_view;
    std::vector<core::Vec3> m_observers;
    const double m_sag;
    const double m_range2;         ///< of the horizontal distance, squared; level-0 voxels
    const double m_target_voxels;  ///< height of the point that is looked for above its voxel
};

}  // namespace terravox::analyse
