#include "raytracer/analyse/evaluators/facade_evaluator.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>

#include "common/util/det_math.hpp"
#include "raytracer/analyse/evaluators/bands.hpp"
#include "raytracer/analyse/evaluators/cell_plane.hpp"
#include "raytracer/analyse/evaluators/column_descent.hpp"
#include "raytracer/analyse/evaluators/wall_outline.hpp"
#include "raytracer/core/base/building_materials.hpp"

namespace terravox::analyse {
namespace {

using core::FacadeBand;

// What a ray is for, in its stream. Those of places of the outline follow.
constexpr std::uint32_t kRoof = 0;  ///< of the cell
constexpr std::uint32_t kFoot = 1;  ///< of the wall, in the neighbouring cell
constexpr std::uint32_t kWall = 2;  ///< level, against the wall
constexpr std::uint32_t kAround = 3;

/// Eaves reach over a wall by less than this.
constexpr double kMaxEaves_m = 2;

// What a cell knows while its rays are on their way is kept in its bands, until PlaneLight keeps
// its own there. Its band of holes stays where it is.
struct Wall {
    float hole = 0;
    float top = 0;      ///< of the cell, level-0 voxels
    float level = 0;    ///< of the voxels
    float waiting = 0;  ///< rays around that are on their way
    float bottom = 0;   ///< of the storey, level-0 voxels
    float height = 0;   ///< the same
    float forward = 0;  ///< from the start of the level ray to that of the light's, level-0 voxels
    std::uint32_t outline[2] = {};
    float unused[7] = {};

    [[nodiscard]] static Wall of(const core::Bands& bands) noexcept {
        return std::bit_cast<Wall>(bands);
    }
    void keep_in(core::Bands& bands) const noexcept { bands = std::bit_cast<core::Bands>(*this); }

    [[nodiscard]] WallOutline seen() const noexcept {
        return WallOutline(std::uint64_t{outline[1]} << 32 | outline[0]);
    }
    void keep(const WallOutline& now) noexcept {
        outline[0] = static_cast<std::uint32_t>(now.bits());
        outline[1] = static_cast<std::uint32_t>(now.bits() >> 32);
    }
};
static_assert(sizeof(Wall) == sizeof(core::Bands));
static_assert(static_cast<std::size_t>(FacadeBand::kHole) == 0);

/// Whether a ray has met vegetation or a wire, which may touch a building or hang over it.
bool is_loose(const walk::TracedRay& ray) noexcept {
    const voxel::Material material = ray.hit.attr.material;
    return voxel::is_plant(material) || material == voxel::Material::kTrunk ||
           material == voxel::Material::kWire;
}

/// The ray that goes on through the material that a level ray has met.
walk::TracedRay through(const walk::TracedRay& ray) noexcept {
    walk::TracedRay out = ray;
    out.state = core::RayState(out.ray);
    out.state.start_in(ray.hit.voxel, ray.hit.level);
    out.state.t = ray.hit.t;
    out.state.face = ray.hit.face;
    out.stop = {ray.hit.attr.material, false};
    out.end = walk::WalkEnd::kWaits;
    return out;
}

}  // namespace

FacadeEvaluator::FacadeEvaluator(const shade::View& view) noexcept
    : m_view(view),
      m_side(view.scene.analysis.side),
      m_outwards(direction_of(m_side)),
      m_spacing(cell_spacing(view)),
      m_storey(view.scene.analysis.storey_m / view.voxel_m),
      m_light(view, PlaneLight::Behind::kFree) {}

void FacadeEvaluator::shade(const walk::TracedRay& ray, shade::SampleSum& sum,
                            std::vector<walk::TracedRay>& next) const {
    const bool is_first = ray.kind == walk::RayKind::kPrimary && ray.stream == kRoof;
    if (!is_first && at(sum.bands, FacadeBand::kHole) > 0)
        return;
    if (is_hole(ray)) {
        sum.bands = no_values(FacadeBand::kHole, true);
    } else if (ray.kind != walk::RayKind::kPrimary) {
        finish_if(m_light.take_through_crowns(ray, sum, next), ray.ray.origin.y, sum);
    } else if (ray.stream == kRoof) {
        shade_cell(ray, sum, next);
    } else if (ray.stream == kFoot) {
        shade_foot(ray, sum, next);
    } else if (ray.stream == kWall) {
        shade_wall(ray, sum, next);
    } else {
        shade_around(ray, sum, next);
    }
}

void FacadeEvaluator::shade_fan(const walk::TracedRay& fan, walk::FanEnds ends,
                                shade::SampleSum& sum, std::vector<walk::TracedRay>& next) const {
    if (ends.holes != 0)
        sum.bands = no_values(FacadeBand::kHole, true);
    else
        finish_if(m_light.take_fan(fan, ends, *this, sum, next), fan.ray.origin.y, sum);
}

void FacadeEvaluator::shade_cell(const walk::TracedRay& ray, shade::SampleSum& sum,
                                 std::vector<walk::TracedRay>& next) const {
    sum.bands = no_values(FacadeBand::kHole, false);
    if (ray.end != walk::WalkEnd::kHit)
        return;
    if (is_loose(ray)) {
        next.push_back(below(ray));
        return;
    }
    if (!core::is_of_building(ray.hit.attr.material))
        return;
    Wall wall;
    wall.top = static_cast<float>(top_of(ray.hit));
    wall.level = ray.hit.level;
    wall.keep_in(sum.bands);
    next.push_back(ray_beside(m_view, ray, m_outwards.x * m_spacing, m_outwards.z * m_spacing));
    next.back().stream = kFoot;
}

void FacadeEvaluator::shade_foot(const walk::TracedRay& ray, shade::SampleSum& sum,
                                 std::vector<walk::TracedRay>& next) const {
    if (ray.end == walk::WalkEnd::kHit && is_loose(ray)) {
        next.push_back(below(ray));
        return;
    }
    auto wall = Wall::of(sum.bands);
    sum.bands = no_values(FacadeBand::kHole, false);
    // Beyond the data there is nothing that a wall could look at.
    if (ray.end != walk::WalkEnd::kHit)
        return;
    const double foot = top_of(ray.hit);
    const auto top = static_cast<double>(wall.top);
    const int level = static_cast<int>(wall.level);
    const double edge = det::exp2_int(level);
    if (top <= foot || is_same_surface(m_spacing, top - foot, edge))
        return;
    const double bottom = foot + m_view.scene.analysis.storey * m_storey;
    const double height = std::min(m_storey, top - bottom);
    if (height <= 0)
        return;
    wall.bottom = static_cast<float>(bottom);
    wall.height = static_cast<float>(height);
    wall.keep_in(sum.bands);
    walk::TracedRay& out = next.emplace_back();
    out.ray = {{ray.ray.origin.x, bottom + height / 2, ray.ray.origin.z}, m_outwards * -1.0};
    out.state = core::RayState(out.ray);
    out.state.start_in(voxel_at(out.ray.origin, level), level);
    out.sample = ray.sample;
    out.stream = kWall;
}

void FacadeEvaluator::shade_wall(const walk::TracedRay& ray, shade::SampleSum& sum,
                                 std::vector<walk::TracedRay>& next) const {
    auto wall = Wall::of(sum.bands);
    const double edge = det::exp2_int(static_cast<int>(wall.level));
    const double farthest = m_spacing + std::max(kMaxEaves_m / m_view.voxel_m, edge);
    const bool is_near = ray.end == walk::WalkEnd::kHit && ray.hit.t < farthest;
    if (is_near && is_loose(ray)) {
        next.push_back(through(ray));
        return;
    }
    // Open below the roof, or no wall of a building.
    if (!is_near || !core::is_of_building(ray.hit.attr.material)) {
        sum.bands = no_values(FacadeBand::kHole, false);
        return;
    }
    wall.forward = static_cast<float>(std::max(ray.hit.t - edge / 2, 0.0));
    wall.keep(WallOutline());
    const std::size_t before = next.size();
    for (std::uint32_t place = 0; place < WallOutline::kCells; ++place) {
        if (place == WallOutline::kOfCell || !WallOutline::is_near(place))
            continue;
        const core::Vec3 step =
            m_outwards * -1.0 + core::Vec3{static_cast<double>(WallOutline::east_of(place)), 0,
                                           static_cast<double>(WallOutline::south_of(place))};
        next.push_back(ray_beside(m_view, ray, step.x * m_spacing, step.z * m_spacing));
        next.back().stream = kAround + place;
    }
    wall.waiting = static_cast<float>(next.size() - before);
    wall.keep_in(sum.bands);
}

void FacadeEvaluator::shade_around(const walk::TracedRay& ray, shade::SampleSum& sum,
                                   std::vector<walk::TracedRay>& next) const {
    const bool is_hit = ray.end == walk::WalkEnd::kHit;
    if (is_hit && is_loose(ray)) {
        next.push_back(below(ray));
        return;
    }
    auto wall = Wall::of(sum.bands);
    const double middle = static_cast<double>(wall.bottom) + static_cast<double>(wall.height) / 2;
    const std::uint32_t place = ray.stream - kAround;
    if (is_hit && top_of(ray.hit) > middle) {
        WallOutline outline = wall.seen();
        outline.add(place);
        wall.keep(outline);
    }
    wall.waiting -= 1;
    wall.keep_in(sum.bands);
    if (wall.waiting > 0)
        return;
    const core::Vec3 normal = wall.seen().normal(m_side);
    const int level = static_cast<int>(wall.level);
    const double edge = det::exp2_int(level);
    const core::Vec3 cell{ray.ray.origin.x - WallOutline::east_of(place) * m_spacing, middle,
                          ray.ray.origin.z - WallOutline::south_of(place) * m_spacing};
    // Stairs reach over the line that is as far from this face by up to half of a voxel.
    const double along = core::dot(normal, m_outwards);
    const double lift = edge / 2 * std::sqrt(std::max(1 - along * along, 0.0));
    const core::Vec3 from =
        cell + m_outwards * (m_spacing - static_cast<double>(wall.forward)) + normal * lift;
    const FanStart start = start_at(from, level, ray.sample);
    finish_if(m_light.begin(normal, wall.height, start, sum, next), middle, sum);
}

void FacadeEvaluator::finish_if(bool is_complete, double middle,
                                shade::SampleSum& sum) const noexcept {
    if (!is_complete)
        return;
    const PlaneLight::Result light = m_light.result(sum.bands);
    const double height_m = static_cast<double>(light.kept) * m_view.voxel_m;
    const double along = core::dot(light.normal, m_outwards);
    core::Bands out{};
    at(out, FacadeBand::kTotal) = static_cast<float>(light.total());
    at(out, FacadeBand::kBeam) = static_cast<float>(light.beam);
    at(out, FacadeBand::kDiffuse) = static_cast<float>(light.diffuse);
    at(out, FacadeBand::kReflected) = static_cast<float>(light.reflected);
    at(out, FacadeBand::kSunHours) = light.sun_hours;
    at(out, FacadeBand::kSkyView) = static_cast<float>(light.sky_view);
    at(out, FacadeBand::kAzimuth) = static_cast<float>(azimuth_deg(light.normal));
    at(out, FacadeBand::kBottom) = static_cast<float>(middle * m_view.voxel_m - height_m / 2);
    at(out, FacadeBand::kHeight) = static_cast<float>(height_m);
    at(out, FacadeBand::kArea) = static_cast<float>(m_spacing * m_view.voxel_m * height_m * along);
    sum.bands = out;
}

}  // namespace terravox::analyse
