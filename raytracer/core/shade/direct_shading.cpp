#include "raytracer/core/shade/direct_shading.hpp"

#include <algorithm>

#include "raytracer/core/shade/optics.hpp"

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
            m.surface.normal, m.sum.numbers.part(i, count).pair(number_of(m.ray, kAmbientRays)));
        walk::TracedRay& out = send(m, direction, walk::RayKind::kAmbient,
                                    light * (strength / static_cast<float>(count)), branch);
        out.direct = m.ray.direct;
        out.t_max = q.ao_range_m / m_view.voxel_m;
        if (m.ray.medium != voxel::Material::kAir)
            out.stop = {m.ray.medium, false};
    }
}

}  // namespace terravox::shade
