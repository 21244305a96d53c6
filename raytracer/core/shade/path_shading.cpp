#include "raytracer/core/shade/path_shading.hpp"

#include <algorithm>
#include <numbers>

#include "raytracer/core/shade/optics.hpp"
#include "raytracer/core/walk/lamp_query.hpp"

namespace terravox::shade {
namespace {

constexpr double kInversePi = std::numbers::inv_pi;

/// Whether the ray has met a lamp whose light was sampled at the ray's origin.
bool was_sampled(const walk::TracedRay& ray) noexcept {
    if (!(ray.lamps_reach > 0) || ray.hit.attr.material != voxel::Material::kLamp)
        return false;
    const walk::LampVoxel lamp{ray.hit.voxel, ray.hit.level, ray.hit.attr};
    const core::Vec3 to = lamp.middle() - ray.ray.origin;
    const auto reach = static_cast<double>(ray.lamps_reach);
    return core::dot(to, to) <= reach * reach;
}

}  // namespace

bool PathShading::needs_surroundings(const walk::TracedRay& ray) const noexcept {
    return ray.kind != walk::RayKind::kBounce && allows_surroundings(ray) &&
           shows_slope(m_view, ray.hit);
}

// The direction of a bounce that leaves the world was sampled from the matt face; the sky could
// have been sampled in the same direction.
void PathShading::miss(const walk::TracedRay& ray, voxel::Colour weight, SampleSum& sum) const {
    const sky::Sky& sky = m_view.sky;
    voxel::Colour light = sky.radiance(ray.ray.direction);
    // The sun has been sampled directly, except by way of mirrors; also through water, from its
    // bed.
    if (ray.density == 0 && !ray.sun_counted)
        light = light + sky.sun_disc(ray.ray.direction);
    if (const auto own = static_cast<double>(ray.density); own > 0 && sky.uneven())
        light = light * static_cast<float>(own / (own + sky.pdf(ray.ray.direction)));
    // Light that reaches the first hit by a bounce has come from the sky without a detour.
    add(ray.direct || (ray.kind == walk::RayKind::kBounce && ray.depth == 1), weight * light, sum);
}

void PathShading::shade_opaque(const Interaction& m) const {
    const auto& q = m_view.scene.quality;
    const Surface& s = m.surface;
    if (!was_sampled(m.ray))
        add(m.ray, m.weight * s.emission, m.sum);
    if (s.polish > 0 && q.reflections) {
        const double mirrored = static_cast<double>(s.polish) *
                                fresnel(std::min(1.0, -core::dot(s.direction, s.normal)), s.index);
        if (m.sum.numbers.number(number_of(m.ray, kChoice)) < mirrored) {
            if (static_cast<int>(m.ray.depth) < q.bounces)
                send_mirror(m, m.weight);
            return;
        }
    }
    const voxel::Colour matt = m.weight * s.albedo;
    send_sun(m, matt);
    send_lamp(m, matt);
    if (m_view.sky.uneven() && m.ray.medium == voxel::Material::kAir)
        send_sky(m, matt);
    if (static_cast<int>(m.ray.depth) < q.bounces)
        bounce(m, matt);
    else if (!m_view.sky.uneven() && m.ray.medium == voxel::Material::kAir)
        send_even_sky(m, matt);
}

// Only one face of a path has the depth 0.
Sampler::Pair PathShading::direction_numbers(const Interaction& m, std::uint32_t use) noexcept {
    const Sampler& numbers = m.sum.numbers;
    const std::uint32_t dimension = number_of(m.ray, use);
    return m.ray.depth == 0 ? numbers.across_pixel(dimension) : numbers.pair(dimension);
}

// The last face has no bounce that would meet the sky.
void PathShading::send_even_sky(const Interaction& m, voxel::Colour weight) const {
    const core::Vec3 direction =
        cosine_direction(m.surface.normal, direction_numbers(m, kDirection));
    const voxel::Colour light = weight * m_view.sky.radiance(direction);
    if (!(voxel::luminance(light) > 0))
        return;
    send(m, direction, walk::RayKind::kSky, light, kSkyPoint).direct = m.ray.depth == 0;
}

void PathShading::send_sky(const Interaction& m, voxel::Colour weight) const {
    const auto at = direction_numbers(m, kSkyPoint);
    const sky::SkySample to = m_view.sky.sample(at.u, at.v);
    const double facing = core::dot(m.surface.normal, to.direction);
    if (!(facing > 0) || !(to.pdf > 0))
        return;
    const double of_bounce =
        static_cast<int>(m.ray.depth) < m_view.scene.quality.bounces ? facing * kInversePi : 0;
    const voxel::Colour light = weight * m_view.sky.radiance(to.direction) *
                                static_cast<float>(facing * kInversePi / (to.pdf + of_bounce));
    send(m, to.direction, walk::RayKind::kSky, light, kSkyPoint).direct = m.ray.depth == 0;
}

void PathShading::bounce(const Interaction& m, voxel::Colour weight) const {
    // Russian roulette: dim paths end, and the remaining ones represent them.
    constexpr int kSafeDepth = 2;
    if (static_cast<int>(m.ray.depth) >= kSafeDepth) {
        const float brightest = std::max({weight.r, weight.g, weight.b});
        const float goes_on = std::clamp(brightest, 0.05f, 1.0f);
        if (m.sum.numbers.number(number_of(m.ray, kEnd)) >= static_cast<double>(goes_on))
            return;
        weight = weight * (1 / goes_on);
    }
    const core::Vec3 direction =
        cosine_direction(m.surface.normal, direction_numbers(m, kDirection));
    walk::TracedRay& out = send(m, direction, walk::RayKind::kBounce, weight, kDirection);
    out.sun_counted = m.ray.medium != voxel::Material::kAir;
    if (m.ray.lamp.looked)
        out.lamps_reach = static_cast<float>(walk::LampQuery::reach_of(m.ray.hit.level));
    out.density = static_cast<float>(core::dot(direction, m.surface.normal) * kInversePi);
}

}  // namespace terravox::shade
