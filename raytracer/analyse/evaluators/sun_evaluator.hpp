#pragma once

#include "raytracer/analyse/evaluators/cell_evaluator.hpp"
#include "raytracer/core/shade/shading.hpp"

namespace terravox::analyse {

/// Measures the sun's bands (core::SunBand and others, by the kind): from the middle of each cell's
/// top, or of its ground, a ray in each direction of the view's sun way. Whatever blocks it puts
/// the cell into shadow for all of the direction's time.
class SunEvaluator final : public CellEvaluator {
public:
    explicit SunEvaluator(const shade::View& view) noexcept : m_view(view) {}

    void shade(const walk::TracedRay& ray, shade::SampleSum& sum,
               std::vector<walk::TracedRay>& next) const override;
    [[nodiscard]] walk::FanDirections directions(std::uint32_t stream) const override;
    void shade_fan(const walk::TracedRay& fan, walk::FanEnds ends, shade::SampleSum& sum,
                   std::vector<walk::TracedRay>& next) const override;

private:
    [[nodiscard]] core::Bands without_sun() const noexcept;
    void add_sunlit(const solar::SunDirection& from, core::Bands& bands) const noexcept;
    /// Sends the fan that begins with direction `first`, if there are so many.
    void send_to_sun(const FanStart& start, std::size_t first,
                     std::vector<walk::TracedRay>& next) const;
    const shade::View& m_view;
};

/// Shows how long the sun shines on what a camera sees, on one day: for the window, where it
/// becomes finer with each sample. The red channel of a sample is the share of the view's sun way
/// in which the first face that its ray meets is in the sun, the green channel is 1 where data is
/// missing. Each sample looks at kRays moments, evenly over the day from a random one on.
class SunViewEvaluator final : public shade::RayEvaluator {
public:
    static constexpr std::size_t kRays = 8;

    explicit SunViewEvaluator(const shade::View& view) noexcept : m_view(view) {}

    [[nodiscard]] walk::TracedRay primary(const core::Ray& ray,
                                          std::uint32_t sample) const noexcept override;
    [[nodiscard]] bool needs_surroundings(const walk::TracedRay& /*ray*/) const noexcept override {
        return false;
    }
    void shade(const walk::TracedRay& ray, shade::SampleSum& sum,
               std::vector<walk::TracedRay>& next) const override;
    [[nodiscard]] walk::FanDirections directions(std::uint32_t stream) const override;
    void shade_fan(const walk::TracedRay& fan, walk::FanEnds ends, shade::SampleSum& sum,
                   std::vector<walk::TracedRay>& next) const override;

private:
    void shade_face(const walk::TracedRay& ray, shade::SampleSum& sum,
                    std::vector<walk::TracedRay>& next) const;
    const shade::View& m_view;
};

}  // namespace terravox::analyse
