#pragma once

#include "raytracer/analyse/evaluators/cell_evaluator.hpp"
#include "raytracer/analyse/evaluators/cell_fan.hpp"
#include "raytracer/analyse/evaluators/sky_directions.hpp"

namespace terravox::analyse {

/// Measures core::SkyBand: from the middle of each cell's top, or of its ground, rays in all
/// directions of the upper half of a sphere. A voxel of any material blocks them, leaves and panes
/// as well; what lies outside of the world's bounds does not.
class SkyEvaluator final : public CellEvaluator {
public:
    explicit SkyEvaluator(const shade::View& view);

    void shade(const walk::TracedRay& ray, shade::SampleSum& sum,
               std::vector<walk::TracedRay>& next) const override;
    [[nodiscard]] walk::FanDirections directions(std::uint32_t stream) const override;
    void shade_fan(const walk::TracedRay& fan, walk::FanEnds ends, shade::SampleSum& sum,
                   std::vector<walk::TracedRay>& next) const override;

private:
    /// A part of a set of directions.
    struct Part {
        std::size_t set;
        std::size_t first;  ///< direction of the set
        std::size_t end;
    };
    /// The part that fans of a stream look at.
    [[nodiscard]] Part part_of(std::uint32_t stream) const noexcept;
    void send_to_sky(const FanStart& start, std::size_t set, std::size_t first,
                     std::vector<walk::TracedRay>& next) const;
    const shade::View& m_view;
    const SkyDirections m_directions;
    const std::uint32_t m_fans;  ///< of a set
    const double m_range;        ///< level-0 voxels
};

}  // namespace terravox::analyse
