#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "raytracer/analyse/evaluators/analysis.hpp"
#include "raytracer/core/base/analysis_bands.hpp"
#include "raytracer/core/base/scene_words.hpp"
#include "raytracer/core/shade/shading.hpp"
#include "raytracer/core/shade/view.hpp"
#include "raytracer/core/walk/traced_ray.hpp"

namespace terravox::analyse {

using core::AnalysisKind;

template <AnalysisKind kind>
inline constexpr Analysis kAnalysis{};

template <AnalysisKind kind>
const Analysis& find_analysis() noexcept {
    return kAnalysis<kind>;
}

/// The value of a band of a cell.
/// @param band of the evaluator's enumeration
template <class Band>
[[nodiscard]] float& at(core::Bands& bands, Band band) noexcept {
    static_assert(std::is_enum_v<Band>);
    return bands[static_cast<std::size_t>(band)];
}

/// Bands without any value. The first one of all kinds counts holes.
/// @param is_hole whether a box that is not available is the reason
[[nodiscard]] inline core::Bands no_values(bool is_hole) noexcept {
    core::Bands out;
    out.fill(core::kNoData);
    out[0] = is_hole ? 1.0F : 0.0F;
    return out;
}
[[nodiscard]] inline bool has_hole(const core::Bands& bands) noexcept {
    return bands[0] > 0;
}

// A cell is measured by one ray straight down through its middle. Where the ground is wanted, the
// ray goes on below whatever else it meets, one voxel after the other.

/// A coordinate, rounded to 1/1024 of a voxel: on the boundary between two voxels rounding must not
/// choose one of them. An exact boundary belongs to the voxel east or south of it.
[[nodiscard]] double on_grid(double at) noexcept;

/// The vertical ray of a cell, from a ray of the camera.
[[nodiscard]] walk::TracedRay cell_ray(const core::Ray& ray, std::uint32_t sample) noexcept;

/// Distance of neighbouring cells, level-0 voxels.
[[nodiscard]] double cell_spacing(const shade::View& view) noexcept;

/// A vertical ray at a distance from another ray, from above the world. Outside of the world it has
/// ended already.
/// @param east, south of the other's origin, level-0 voxels
[[nodiscard]] walk::TracedRay ray_beside(const shade::View& view, const walk::TracedRay& ray,
                                         double east, double south) noexcept;

/// The voxel of a level that holds a point.
/// @param at level-0 voxels
[[nodiscard]] core::VoxelCoord voxel_at(core::Vec3 at, int level) noexcept;

/// Whether a ray has ended at a box that is not available.
[[nodiscard]] inline bool is_hole(const walk::TracedRay& ray) noexcept {
    return ray.end == walk::WalkEnd::kHit && ray.hit.hole;
}

/// Height of the top of the voxel that a vertical ray has met, level-0 voxels.
[[nodiscard]] double find_top(const walk::Hit& hit) noexcept;

/// Whether a material is the surface of terrain: ground of any kind, water, ice.
[[nodiscard]] bool is_ground(voxel::Material material) noexcept;

enum class Descent : std::uint8_t {
    kGround,  ///< the ray has met the ground
    /// The ground is below here, but its height is unknown: inside of what is opaque on all sides,
    /// such as a building, boxes hold no materials.
    kCovered,
    kContinues,
};
/// What a vertical ray's hit, which must not be a hole, means for the search for the ground.
/// @param ray of cell_ray() or below()
[[nodiscard]] Descent descent_at(const walk::TracedRay& ray) noexcept;

/// What a vertical ray means for an analysis that measures at one point of the cell.
enum class CellStep : std::uint8_t {
    kMeasure,  ///< at the top of the voxel that it has met
    kDescend,  ///< further down: below()
    kNothing,  ///< nowhere: the cell has no value
};
/// @param ray at its end
[[nodiscard]] CellStep cell_step_at(const walk::TracedRay& ray,
                                    core::AnalysisSurface surface) noexcept;

/// Whether a ray to the sun or the sky, at its end, has met nothing: no voxel, and no terrain
/// outside of the data.
[[nodiscard]] inline bool is_free(const walk::TracedRay& ray, const Sunlight& sunlight) noexcept {
    return ray.end != walk::WalkEnd::kHit &&
           !sunlight.horizon.hides(ray.ray.origin, ray.ray.direction);
}

/// The ray that goes on below the voxel that a vertical ray has met.
[[nodiscard]] walk::TracedRay below(const walk::TracedRay& ray) noexcept;

/// So many cells that look at sun or sky are begun together. More of them are not faster, and each
/// may have up to some forty rays in a wave: to its neighbours, or those of a fan that walk alone.
inline constexpr std::size_t kMostWaveCells = 512;

/// Measures cells, each from one vertical ray through its middle.
class CellEvaluator : public shade::RayEvaluator {
public:
    [[nodiscard]] std::size_t wave_pixels(std::size_t rays) const noexcept override {
        return std::min(rays, kMostWaveCells);
    }
    [[nodiscard]] walk::TracedRay primary(const core::Ray& ray,
                                          std::uint32_t sample) const noexcept override {
        return cell_ray(ray, sample);
    }
    [[nodiscard]] bool needs_surroundings(const walk::TracedRay& /*ray*/) const noexcept final {
        return false;
    }

protected:
    /// Takes a vertical ray of a cell at its end: the cell has no values, and a ray may go on.
    /// @return whether the cell is measured where the ray has ended
    [[nodiscard]] static bool lands(const walk::TracedRay& ray, const shade::View& view,
                                    shade::SampleSum& sum, std::vector<walk::TracedRay>& next) {
        sum.bands = no_values(is_hole(ray));
        const CellStep step = cell_step_at(ray, view.scene.analysis.surface);
        if (step == CellStep::kDescend)
            next.push_back(below(ray));
        return step == CellStep::kMeasure;
    }
};

// A cell looks at sun and sky by fans: the directions of an analysis are cut into fans, and the end
// of one sends the next. So a wave holds one fan of a cell, however many directions there are.

/// Where the rays of a fan start.
struct FanStart {
    core::Vec3 at;  ///< level-0 voxels
    core::VoxelCoord voxel;
    int level = 0;  ///< of the voxel
    std::uint32_t sample = 0;
};
/// @param level of the voxel that holds the point
[[nodiscard]] FanStart start_at(core::Vec3 at, int level, std::uint32_t sample) noexcept;
/// The middle of the top of the voxel that a vertical ray has met.
[[nodiscard]] FanStart start_above(const walk::TracedRay& ray) noexcept;
/// Where a fan has started.
[[nodiscard]] FanStart find_start(const walk::TracedRay& fan) noexcept;
/// The ray that goes on through the material that a ray has met.
[[nodiscard]] walk::TracedRay through(const walk::TracedRay& ray) noexcept;

/// Number of the fan that holds a direction.
[[nodiscard]] constexpr std::uint32_t to_fan(std::size_t direction) noexcept {
    return static_cast<std::uint32_t>(direction / walk::kFanRays);
}
/// One past the last direction of the fan that begins with direction `first`, of `count` in all.
[[nodiscard]] constexpr std::size_t fan_end(std::size_t first, std::size_t count) noexcept {
    return std::min(first + walk::kFanRays, count);
}

/// Adds a fan, made where it lies.
/// @param kind of its rays
/// @param mask of its directions
/// @param stream of its directions (RayEvaluator::directions)
walk::TracedRay& add_fan(const FanStart& start, walk::RayKind kind, walk::FanMask mask,
                         std::uint32_t stream, std::vector<walk::TracedRay>& next);

/// The rays of a fan that have met nothing: no voxel, and no terrain outside of the data.
/// @param evaluator whose fan it is
[[nodiscard]] walk::FanMask free_rays(const walk::TracedRay& fan, walk::FanEnds ends,
                                      const shade::RayEvaluator& evaluator,
                                      const Sunlight& sunlight);

}  // namespace terravox::analyse
