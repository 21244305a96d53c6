#pragma once

#include <limits>
#include <vector>

#include "raytracer/shade/view.hpp"
#include "raytracer/trace/traced_ray.hpp"

namespace terravox {

/// What has come together for one sample of a pixel.
struct SampleSum {
    Colour colour;  ///< linear
    double t = std::numeric_limits<double>::infinity();  ///< of the primary ray's hit, level-0 voxels; infinity: none
};

/// Says what a ray's end means: light for its sample, and rays that must be traced to know more. Walks nothing itself, so that rays
/// may wait. Immutable; a function of its arguments.
class Shading {
public:
    explicit Shading(const View& view) noexcept : m_view(view) {}

    /// What a primary ray brings. Its state is the caller's.
    [[nodiscard]] TracedRay primary(const Ray& ray, std::uint32_t sample) const noexcept;
    /// Whether shade() will ask what stands around the ray's hit (TracedRay::around).
    [[nodiscard]] bool needs_surroundings(const TracedRay& ray) const noexcept;
    /// Adds to the sum what the ray has found, and to `next` the rays that this makes necessary.
    void shade(const TracedRay& ray, SampleSum& sum, std::vector<TracedRay>& next) const;

private:
    void lit(const TracedRay& ray, Colour weight, SampleSum& sum, std::vector<TracedRay>& next) const;
    void water(const TracedRay& ray, Colour weight, std::vector<TracedRay>& next) const;
    [[nodiscard]] Colour bed(const TracedRay& ray) const;
    [[nodiscard]] Colour albedo(const Hit& hit) const;
    const View& m_view;
};

}  // namespace terravox
