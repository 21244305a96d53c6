#pragma once

#include "raytracer/analyse/evaluators/cell_evaluator.hpp"
#include "raytracer/analyse/evaluators/plane_light.hpp"
#include "raytracer/core/base/scene_words.hpp"

namespace terravox::analyse {

/// Measures core::FacadeBand: the light on one storey of the wall between a cell of a building and
/// its lower neighbour on the side that the scene names.
///
/// Vertical rays find the top of the building and, in the neighbouring cell, the foot of the wall,
/// both below crowns. A level ray from the middle of the neighbouring cell tells whether there is a
/// wall at the storey's height. Rays around the cell find the outline of the building there, whose
/// normal is that of the wall: walls of voxels are stairs. From the start of the level ray the
/// light is gathered (PlaneLight). A cell's values depend on no other cell's.
class FacadeEvaluator final : public CellEvaluator {
public:
    explicit FacadeEvaluator(const shade::View& view) noexcept;

    void shade(const walk::TracedRay& ray, shade::SampleSum& sum,
               std::vector<walk::TracedRay>& next) const override;
    [[nodiscard]] walk::FanDirections directions(std::uint32_t stream) const override {
        return m_light.directions(stream);
    }
    void shade_fan(const walk::TracedRay& fan, walk::FanEnds ends, shade::SampleSum& sum,
                   std::vector<walk::TracedRay>& next) const override;

private:
    void shade_cell(const walk::TracedRay& ray, shade::SampleSum& sum,
                    std::vector<walk::TracedRay>& next) const;
    void shade_foot(const walk::TracedRay& ray, shade::SampleSum& sum,
                    std::vector<walk::TracedRay>& next) const;
    void shade_wall(const walk::TracedRay& ray, shade::SampleSum& sum,
                    std::vector<walk::TracedRay>& next) const;
    void shade_around(const walk::TracedRay& ray, shade::SampleSum& sum,
                      std::vector<walk::TracedRay>& next) const;
    /// Makes a wall's values of its light.
    /// @param middle height of the middle of the storey's wall, level-0 voxels
    void finish_if(bool is_complete, double middle, shade::SampleSum& sum) const noexcept;

    const shade::View& m_view;
    const core::WallSide m_side;
    const core::Vec3 m_outwards;  ///< direction_of(m_side)
    const double m_spacing;       ///< of cells, level-0 voxels
    const double m_storey;        ///< height of one, level-0 voxels
    const PlaneLight m_light;
};

}  // namespace terravox::analyse
