#pragma once

#include "raytracer/analyse/evaluators/cell_evaluator.hpp"
#include "raytracer/analyse/evaluators/plane_light.hpp"

namespace terravox::analyse {

/// Measures core::EnergyBand. A cell's surface is the plane through the heights of the cells around
/// it, to which it sends vertical rays of its own, so that its values depend on no other cell's.
/// The light on the plane is that of PlaneLight.
class EnergyEvaluator final : public CellEvaluator {
public:
    explicit EnergyEvaluator(const shade::View& view) noexcept;

    [[nodiscard]] walk::TracedRay primary(const core::Ray& ray,
                                          std::uint32_t sample) const noexcept override;
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
    void shade_neighbour(const walk::TracedRay& ray, shade::SampleSum& sum,
                         std::vector<walk::TracedRay>& next) const;
    void send_to_neighbours(const walk::TracedRay& ray, shade::SampleSum& sum,
                            std::vector<walk::TracedRay>& next) const;
    /// Makes a cell's values of its light.
    void finish_if(bool is_complete, shade::SampleSum& sum) const noexcept;

    const shade::View& m_view;
    const double m_spacing;  ///< of cells, level-0 voxels
    const PlaneLight m_light;
};

}  // namespace terravox::analyse
