#pragma once

#include "raytracer/analyse/cell_plane.hpp"
#include "raytracer/shade/shading.hpp"

namespace terravox::analyse {

/// Measures core::EnergyBand. A cell's surface is the plane through the heights of the cells around
/// it, to which it sends vertical rays of its own, so that its values depend on no other cell's.
/// From the plane it sends a ray in each direction of the view's light; whatever blocks the ray
/// blocks all of the direction's light, but crowns, which let a share of it through, whatever their
/// thickness.
class EnergyEvaluator final : public shade::RayEvaluator {
public:
    explicit EnergyEvaluator(const shade::View& view) noexcept;

    [[nodiscard]] walk::TracedRay primary(const core::Ray& ray,
                                          std::uint32_t sample) const noexcept override;
    [[nodiscard]] bool needs_surroundings(const walk::TracedRay& ray) const noexcept override;
    void shade(const walk::TracedRay& ray, shade::SampleSum& sum,
               std::vector<walk::TracedRay>& next) const override;

private:
    void shade_cell(const walk::TracedRay& ray, shade::SampleSum& sum,
                    std::vector<walk::TracedRay>& next) const;
    void shade_neighbour(const walk::TracedRay& ray, shade::SampleSum& sum,
                         std::vector<walk::TracedRay>& next) const;
    void shade_light(const walk::TracedRay& ray, shade::SampleSum& sum,
                     std::vector<walk::TracedRay>& next) const;
    void send_to_neighbours(const walk::TracedRay& ray, shade::SampleSum& sum,
                            std::vector<walk::TracedRay>& next) const;
    [[nodiscard]] std::size_t directions() const noexcept;
    [[nodiscard]] core::Vec3 direction(std::size_t index) const noexcept;
    /// Sends a blocked ray on through crowns, or once more from where it came.
    /// @return false: what has blocked it lets no light through
    [[nodiscard]] bool sends_through_crowns(const walk::TracedRay& ray,
                                            std::vector<walk::TracedRay>& next) const;
    /// Where the rays of a cell start.
    struct Start {
        core::Vec3 at;  ///< level-0 voxels
        int level = 0;  ///< of its voxel
        std::uint32_t sample = 0;
    };
    /// Sends the chunk of rays that begins with direction `first`.
    void send_to_light(const Start& start, std::size_t first, shade::SampleSum& sum,
                       std::vector<walk::TracedRay>& next) const;
    [[nodiscard]] core::Bands result_of(const core::Bands& memory) const noexcept;

    const shade::View& m_view;
    const double m_spacing;     ///< of cells, level-0 voxels
    const bool m_crowns_shine;  ///< blocked rays are sent once more, through crowns
};

}  // namespace terravox::analyse
