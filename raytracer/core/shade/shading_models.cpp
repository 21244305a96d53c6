#include "raytracer/core/shade/shading_models.hpp"

#include <algorithm>
#include <numbers>

#include "raytracer/core/shade/optics.hpp"
#include "raytracer/core/walk/lamp_query.hpp"

namespace terravox::shade {

bool DirectShading::needs_surroundings(const walk::TracedRay& ray) const noexcept {
    if (!allows_surroundings(ray) || is_transparent(m_view, ray.hit.attr.material))
        return false;
    return (m_view.scene.quality.ambient_occlusion && m_view.scene.quality.ao_rays == 0) ||
           shows_slope(m_view, ray.hit);
}

void DirectShading::miss(const walk::TracedRay& ray, voxel::Colour weight, SampleSum& sum) const {
    add(ray,
        weight * (m_view.sky.radiance(ray.ray.direction) + m_view.sky.sun_disc(ray.ray.direction)),
        sum);
}

void DirectShading::shade_opaque(const Interaction& m) const {
    const auto& q = m_view.scene.quality;
    const Surface& s = m.surface;
    add(m.ray, m.weight * s.emission, m.sum);
    voxel::Colour weight = m.weight;
    if (s.polish > 0 && q.reflections && static_cast<int>(m.ray.depth) < q.bounces) {
        constexpr float kMin = 0.004f;  // of a sample's light; less is invisible
        const float mirrored =
            s.polish *
            static_cast<float>(fresnel(std::min(1.0, -core::dot(s.direction, s.normal)), s.index));
        if (mirrored * std::max({weight.r, weight.g, weight.b}) > kMin) {
            send_mirror(m, weight * mirrored);
            weight = weight * (1 - mirrored);
        }
    }
    const voxel::Colour matt = weight * s.albedo;
    const voxel::Colour sky =
        matt * m_view.sky.ambient(m.ray.hit.face) * through_medium(m, {0, 1, 0});
    if (!q.ambient_occlusion)
        add(m.ray, sky, m.sum);
    else if (q.ao_rays == 0)
        add(m.ray, sky * open_share(m.ray.hit, s.point, m.ray.around.bits), m.sum);
    else
        send_ambient(m, sky);
    send_sun(m, matt);
    send_lamp(m, matt);
}

void DirectShading::send_ambient(const Interaction& m, voxel::Colour light) const {
    const auto& q = m_view.scene.quality;
    const auto strength = static_cast<float>(q.ao_strength);
    add(m.ray, light * (1 - strength), m.sum);
    // What is seen in a mirror is one of many things that make a pixel.
    const int count = m.ray.depth == 0 ? q.ao_rays : 1;
    for (int i = 0; i < count; ++i) {
        const auto branch = static_cast<std::uint32_t>(kAmbientRays + i);
        const core::Vec3 direction = cosine_direction(
            m.surface.normal, m.sum.numbers.part(i, count).pair(to_number(m.ray, kAmbientRays)));
        walk::TracedRay& out = send(m, direction, walk::RayKind::kAmbient,
                                    light * (strength / static_cast<float>(count)), branch);
        out.direct = m.ray.direct;
        out.t_max = q.ao_range_m / m_view.voxel_m;
        if (m.ray.medium != voxel::Material::kAir)
            out.stop = {m.ray.medium, false};
    }
}

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
        if (m.sum.numbers.number(to_number(m.ray, kChoice)) < mirrored) {
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
    const std::uint32_t dimension = to_number(m.ray, use);
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
        if (m.sum.numbers.number(to_number(m.ray, kEnd)) >= static_cast<double>(goes_on))
            return;
        weight = weight * (1 / goes_on);
    }
    const core::Vec3 direction =
        cosine_direction(m.surface.normal, direction_numbers(m, kDirection));
    walk::TracedRay& out = send(m, direction, walk::RayKind::kBounce, weight, kDirection);
    out.sun_counted = m.ray.medium != voxel::Material::kAir;
    if (m.ray.lamp.looked)
        out.lamps_reach = static_cast<float>(walk::LampQuery::measure_reach(m.ray.hit.level));
    out.density = static_cast<float>(core::dot(direction, m.surface.normal) * kInversePi);
}

}  // namespace terravox::shade
