#include "raytracer/shade/cached_shading.hpp"

#include <algorithm>
#include <cmath>

#include "common/util/det_math.hpp"
#include "raytracer/shade/optics.hpp"

namespace terravox::shade {
namespace {

/// Streams of random numbers of a cell.
enum CellUse : std::uint32_t {
    kCellOrigin = 0x2000,
    kCellDirection,
    kCellSunOrigin,
    kCellSunPoint
};

// A cell is about as large as this many pixels along an edge, where its face is larger.
constexpr float kCellPixels = 2;
// The light of a face is kept where it covers at least so many pixels.
constexpr double kMinPixels = 1;

int split_of(int level, float footprint) noexcept {
    float edge = static_cast<float>(det::exp2_int(level));
    int split = 0;
    while (split < FaceCell::kMaxSplit && edge >= 2 * kCellPixels * footprint) {
        edge /= 2;
        ++split;
    }
    return split;
}

core::Vec3 point_of(const FaceCell& cell, Sampler::Pair at) noexcept {
    const core::Face face = cell.face();
    const int axis = core::axis_of(face);
    const double part = det::exp2_int(-cell.split());
    double p[3];
    p[axis] = cell.voxel[axis] + (core::sign_of(face) > 0 ? 1.0 : 0.0);
    const int a = (axis + 1) % 3;
    const int b = (axis + 2) % 3;
    p[a] = cell.voxel[a] + (cell.u() + at.u) * part;
    p[b] = cell.voxel[b] + (cell.v() + at.v) * part;
    return core::Vec3{p[0], p[1], p[2]} * det::exp2_int(cell.level());
}

/// Whether a face covers a pixel, as it is seen. Of smaller ones each would have few samples, and
/// gathering its light would cost more than paths do.
bool is_large(const walk::TracedRay& ray) noexcept {
    const double edge = det::exp2_int(ray.hit.level);
    const auto footprint = static_cast<double>(footprint_at(ray));
    const double facing = std::abs(ray.ray.direction[core::axis_of(ray.hit.face)]);
    return edge * edge * facing >= kMinPixels * footprint * footprint;
}

/// The part of a face's edge that a point of it belongs to.
/// @param jitter [-0.5, 0.5) parts: a pixel's samples see neighbouring parts by their distance, so
/// that the mean goes over smoothly from one to the next
std::uint32_t part_at(double point, int level, std::int32_t voxel, int split,
                      double jitter) noexcept {
    const double parts = det::exp2_int(split);
    const double at = (point * det::exp2_int(-level) - voxel) * parts + jitter;
    return static_cast<std::uint32_t>(std::clamp(at, 0.0, parts - 0.5));
}

}  // namespace

bool CachedShading::is_kept(const walk::TracedRay& ray) const noexcept {
    const walk::Hit& hit = ray.hit;
    if (!allows_surroundings(ray) || ray.medium != voxel::Material::kAir ||
        is_transparent(m_view, hit.attr.material))
        return false;
    if (has_holes(m_view, hit.attr.material) && shows_leaves(hit.level, footprint_at(ray)))
        return false;
    // Where two levels meet, a face may be open to the other level and closed to its own.
    const core::VoxelCoord front = walk::neighbour(hit.voxel, hit.face);
    const int level = hit.level;
    return m_cut.level_at(front.x << level, front.z << level, level) == level;
}

FaceCell CachedShading::face_of(const walk::TracedRay& ray) const noexcept {
    return {ray.hit.voxel, ray.hit.level, ray.hit.face,
            shows_leaves(ray.hit.level, footprint_at(ray))};
}

int CachedShading::bounces_at(const walk::TracedRay& ray) const noexcept {
    return std::max(m_view.scene.quality.bounces - static_cast<int>(ray.depth), 0);
}

std::optional<FaceCell> CachedShading::kept_light_of(const walk::TracedRay& ray,
                                                     const Sampler& numbers) const noexcept {
    if (ray.kind == walk::RayKind::kBounce || !is_kept(ray) || !is_large(ray))
        return std::nullopt;
    const walk::Hit& hit = ray.hit;
    const FaceCell face = face_of(ray);
    const int bounces = bounces_at(ray);
    const int split = split_of(hit.level, footprint_at(ray));
    if (split == 0)
        return face.light(bounces, true);
    const int axis = core::axis_of(hit.face);
    const int a = (axis + 1) % 3;
    const int b = (axis + 2) % 3;
    const core::Vec3 point = ray.ray.origin + ray.ray.direction * hit.t;
    const Sampler::Pair jitter = numbers.pair(number_of(ray, kCellPoint));
    return face
        .part(split, part_at(point[a], hit.level, hit.voxel[a], split, jitter.u - 0.5),
              part_at(point[b], hit.level, hit.voxel[b], split, jitter.v - 0.5))
        .light(bounces, true);
}

void CachedShading::shade_opaque(const Interaction& m) const {
    if (!m.ray.has_kept && (m.sum.gathered == nullptr || !is_kept(m.ray))) {
        PathShading::shade_opaque(m);
        return;
    }
    add(m.ray, m.weight * m.surface.emission, m.sum);
    if (takes_mirror(m))
        return;
    const voxel::Colour matt = m.weight * m.surface.albedo;
    if (m.sum.gathered != nullptr) {
        m.sum.gathered->push_back(
            {m.ray.sample, {face_of(m.ray).light(bounces_at(m.ray), false), matt}});
        return;
    }
    send_sun(m, matt);
    add(m.ray.depth == 0, matt * m.ray.kept_direct, m.sum);
    add(false, matt * m.ray.kept_indirect, m.sum);
}

Sampler CachedShading::numbers_of(const FaceCell& cell, std::uint32_t index) const noexcept {
    const auto seed = static_cast<std::uint32_t>(m_view.scene.quality.seed);
    return {core::hash64(cell.hash(), seed), index};
}

walk::TracedRay CachedShading::from_cell(const FaceCell& cell, core::Vec3 point,
                                         core::Vec3 direction) const noexcept {
    walk::TracedRay out;
    out.ray = {point, direction};
    out.state = core::RayState(out.ray);
    out.state.start_in(walk::neighbour(cell.voxel, cell.face()), cell.level());
    out.footprint = cell.fine() ? 0 : static_cast<float>(det::exp2_int(cell.level()));
    out.spread = kDiffuseSpread;
    out.depth = 1;
    return out;
}

walk::TracedRay CachedShading::gather_ray(const FaceCell& key, std::uint32_t index,
                                          std::uint32_t sample) const noexcept {
    const FaceCell cell = key.cell();
    const Sampler numbers = numbers_of(cell, index);
    walk::TracedRay out =
        from_cell(cell, point_of(cell, numbers.pair(kCellOrigin)),
                  cosine_direction(core::normal_of(cell.face()), numbers.pair(kCellDirection)));
    out.weight = {1, 1, 1};
    out.sample = sample;
    out.stream = static_cast<std::uint32_t>(core::hash64(index, 0x3000));
    if (key.bounces() == 0) {
        // Only the sky counts.
        out.kind = walk::RayKind::kSky;
        out.weight = m_view.sky.radiance(out.ray.direction);
        out.leaves = shows_leaves(cell.level(), out.footprint);
        return out;
    }
    out.kind = walk::RayKind::kBounce;
    out.depth =
        static_cast<std::uint8_t>(std::max(m_view.scene.quality.bounces - key.bounces() + 1, 1));
    out.direct = false;
    out.sun_counted = true;
    return out;
}

std::optional<walk::TracedRay> CachedShading::sun_ray(const FaceCell& key, std::uint32_t index,
                                                      std::uint32_t sample,
                                                      float share) const noexcept {
    const FaceCell cell = key.cell();
    const Sampler numbers = numbers_of(cell, index);
    const auto at = numbers.pair(kCellSunPoint);
    const core::Vec3 direction = m_view.sky.sample_sun(at.u, at.v);
    const double facing = core::dot(core::normal_of(cell.face()), direction);
    if (!(facing > 0) || !(direction.y > 0))
        return std::nullopt;
    const core::Vec3 point = point_of(cell, numbers.pair(kCellSunOrigin));
    walk::TracedRay out = from_cell(cell, point, direction);
    out.weight = m_view.sky.sun_light() * (share * static_cast<float>(facing)) *
                 m_view.sky.cloud_shadow(point * m_view.voxel_m);
    out.sample = sample;
    out.stream = static_cast<std::uint32_t>(core::hash64(index, 0x3001));
    out.kind = walk::RayKind::kShadow;
    out.spread = 0;
    out.leaves = shows_leaves(cell.level(), out.footprint);
    return out;
}

}  // namespace terravox::shade
