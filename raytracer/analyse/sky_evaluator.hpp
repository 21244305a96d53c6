#pragma once

#include "raytracer/analyse/cell_evaluator.hpp"
#include "raytracer/analyse/sky_directions.hpp"

namespace terravox::analyse {

/// Measures core::SkyBand: from the middle of each cell's top, or of its ground, rays in all
/// directions of the upper half of a sphere. A voxel of any material blocks them, leaves and panes
/// as well; what lies outside of the world's bounds does not.
class SkyEvaluator final : public CellEvaluator {
public:
    explicit SkyEvaluator(const shade::View& view);

    void shade(const walk::TracedRay& ray, shade::SampleSum& sum,
               std::vector<walk::TracedRay>& next) const override;

private:
    void shade_cell(const walk::TracedRay& ray, shade::SampleSum& sum,
                    std::vector<walk::TracedRay>& next) const;
    /// Sends the chunk of rays that begins with direction `first`.
    void send_to_sky(const walk::TracedRay& ray, std::size_t first,
                     std::vector<walk::TracedRay>& next) const;
    const shade::View& m_view;
    const SkyDirections m_directions;
    const double m_range;  ///< level-0 voxels
};

}  // namespace terravox::analyse
