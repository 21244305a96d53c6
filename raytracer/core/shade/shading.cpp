#include "raytracer/core/shade/shading.hpp"

#include <algorithm>
#include <cmath>

#include "raytracer/core/shade/optics.hpp"
#include "raytracer/core/shade/shading_models.hpp"

namespace terravox::shade {
namespace {

// Nothing in nature has this colour: a hole must be visible.
constexpr voxel::Colour kHoleColour{1.0f, 0.0f, 0.8f};
constexpr voxel::Colour kWhole{1, 1, 1};
// Spread of a ray from a matt face, relative to its neighbours.
constexpr float kDiffuseSpread = 0.2f;

voxel::Colour decay(voxel::Colour per_m, double metres) noexcept {
    const auto left = [&](float c) {
        return static_cast<float>(det::exp(-static_cast<double>(c) * metres));
    };
    return {left(per_m.r), left(per_m.g), left(per_m.b)};
}

// Leaves show their holes where a pixel is small enough to show them, and are whole farther off.
bool shows_leaves(const View& view, const walk::Hit& hit, float footprint) noexcept {
    constexpr float kMaxFootprint = 1.0f;
    return view.scene.quality.cut_outs && view.scene.quality.textures && hit.level == 0 &&
           footprint < kMaxFootprint;
}

core::RayState behind(const walk::TracedRay& ray) noexcept {
    core::RayState out(ray.ray);
    out.start_in(ray.hit.voxel, ray.hit.level);
    out.t = ray.hit.t;
    out.face = ray.hit.face;
    return out;
}

}  // namespace

std::size_t Shading::wave_pixels(std::size_t rays) const noexcept {
    const auto& quality = m_view.scene.quality;
    const bool has_ambient_rays =
        quality.integrator == core::Integrator::kDirect && quality.ambient_occlusion;
    return has_ambient_rays ? rays / (1 + static_cast<std::size_t>(quality.ao_rays) / 2) : rays;
}

walk::TracedRay Shading::primary(const core::Ray& ray, std::uint32_t sample) const noexcept {
    walk::TracedRay out;
    out.ray = ray;
    out.weight = kWhole;
    out.sample = sample;
    out.footprint = static_cast<float>(m_view.camera.pixel_voxels(0));
    out.spread = static_cast<float>(m_view.camera.pixel_rad());
    return out;
}

bool Shading::allows_surroundings(const walk::TracedRay& ray) const noexcept {
    return ray.end == walk::WalkEnd::kHit && !ray.is_occlusion() && !ray.hit.hole &&
           ray.hit.face != core::Face::kNone && ray.hit.attr.material != voxel::Material::kAir;
}

void Shading::add(bool direct, voxel::Colour light, SampleSum& sum) const noexcept {
    voxel::Colour& to = direct ? sum.direct : sum.indirect;
    const float brightest = std::max({light.r, light.g, light.b});
    const float limit = m_view.max_indirect;
    if (!direct && limit > 0 && brightest > limit)
        light = light * (limit / brightest);
    to = to + light;
}

void Shading::shade(const walk::TracedRay& ray, SampleSum& sum,
                    std::vector<walk::TracedRay>& next) const {
    if (!ray.is_occlusion()) {
        shade_hit(ray, sum, next);
        return;
    }
    if (ray.end == walk::WalkEnd::kHit) {
        if (!ray.leaves || ray.hit.hole || !has_holes(m_view, ray.hit.attr.material))
            return;
        // A face between leaves sends its rays from among them.
        if (ray.hit.face == core::Face::kNone || slips_through(ray, surface_at(m_view, ray), sum))
            continue_through(ray, next);
        return;
    }
    add(ray, ray.weight, sum);
    if (ray.kind == walk::RayKind::kShadow && ray.direct)
        sum.sun = 1;
}

bool Shading::slips_through(const walk::TracedRay& ray, const Surface& surface,
                            const SampleSum& sum) const noexcept {
    return surface.leaves && surface.opacity < 1 &&
           shows_leaves(m_view, ray.hit, footprint_at(ray)) &&
           static_cast<double>(surface.opacity) <= sum.numbers.number(to_number(ray, kOpacity));
}

voxel::Colour Shading::through_water(const walk::TracedRay& ray, voxel::Colour weight,
                                     SampleSum& sum) const {
    constexpr double kBottomless_m = 1000;
    const bool hit = ray.end == walk::WalkEnd::kHit;
    const Medium medium = find_medium(m_view, ray.medium);
    const voxel::Colour left =
        decay(medium.absorption_per_m, hit ? ray.hit.t * m_view.voxel_m : kBottomless_m);
    const sky::Sky& sky = m_view.sky;
    const voxel::Colour glow =
        medium.glow * (sky.ambient(core::Face::kTop) +
                       sky.sun_light() * static_cast<float>(std::max(0.0, sky.to_sun().y)));
    add(ray, weight * glow * voxel::Colour{1 - left.r, 1 - left.g, 1 - left.b}, sum);
    return weight * left;
}

voxel::Colour Shading::through_air(const walk::TracedRay& ray, voxel::Colour weight,
                                   SampleSum& sum) const {
    if (ray.medium != voxel::Material::kAir || ray.kind == walk::RayKind::kBounce)
        return weight;
    // Parallel rays start wherever the picture's plane is: there is no air to look through.
    if (ray.kind == walk::RayKind::kPrimary &&
        m_view.camera.projection() == scene::Projection::kOrthographic)
        return weight;
    const auto air = m_view.sky.air(ray.ray.direction, ray.hit.t * m_view.voxel_m);
    add(ray, weight * air.light, sum);
    return weight * air.transmittance;
}

void Shading::start_inside(const walk::TracedRay& ray, bool transparent,
                           std::vector<walk::TracedRay>& next) const {
    if (ray.kind == walk::RayKind::kPrimary && transparent && ray.medium == voxel::Material::kAir)
        enter_medium(ray, next);
    else if (has_holes(m_view, ray.hit.attr.material))
        continue_through(ray, next);
}

void Shading::shade_hit(const walk::TracedRay& ray, SampleSum& sum,
                        std::vector<walk::TracedRay>& next) const {
    const bool hit = ray.end == walk::WalkEnd::kHit;
    const bool face_met = hit && !ray.hit.hole && ray.hit.face != core::Face::kNone;
    const Surface surface = face_met ? surface_at(m_view, ray) : Surface{};
    // Before anything is summed up: light from in front of the gap is added where the ray ends.
    if (face_met && slips_through(ray, surface, sum)) {
        continue_through(ray, next);
        return;
    }
    voxel::Colour weight = ray.weight;
    if (ray.medium != voxel::Material::kAir) {
        weight = through_water(ray, weight, sum);
        if (!hit)
            return;
    } else if (!hit) {
        miss(ray, weight, sum);
        return;
    }
    if (ray.hit.hole) {
        weight = through_air(ray, weight, sum);
        add(ray, weight * kHoleColour, sum);
        return;
    }
    const bool transparent = is_transparent(m_view, ray.hit.attr.material);
    if (ray.hit.face == core::Face::kNone) {
        start_inside(ray, transparent, next);
        return;
    }
    weight = through_air(ray, weight, sum);
    if (ray.kind == walk::RayKind::kPrimary) {
        sum.t = ray.hit.t;
        sum.point = surface.point;
        sum.normal = surface.smooth_normal;
        sum.albedo = surface.albedo;
        sum.material = ray.hit.attr.material;
        sum.water = transparent;
    }
    const Interaction m{ray, surface, weight, sum, next};
    if (transparent || ray.hit.attr.material == voxel::Material::kAir)
        shade_transparent(m);
    else
        shade_opaque(m);
}

walk::TracedRay& Shading::send(const Interaction& m, core::Vec3 direction, walk::RayKind kind,
                               voxel::Colour weight, std::uint32_t branch) const {
    walk::TracedRay& out = m.next.emplace_back();
    out.ray = {m.surface.point, direction};
    out.state = core::RayState(out.ray);
    out.state.start_in(walk::neighbour(m.ray.hit.voxel, m.ray.hit.face), m.ray.hit.level);
    out.weight = weight;
    out.sample = m.ray.sample;
    out.stream = static_cast<std::uint32_t>(core::hash64(m.ray.stream, 0x100 + branch));
    out.footprint = footprint_at(m.ray);
    out.spread = kind == walk::RayKind::kBounce || kind == walk::RayKind::kSky ||
                         kind == walk::RayKind::kAmbient
                     ? kDiffuseSpread
                     : m.ray.spread;
    out.kind = kind;
    out.depth = static_cast<std::uint8_t>(m.ray.depth + 1);
    out.direct = false;
    out.leaves = out.is_occlusion() && shows_leaves(m_view, m.ray.hit, out.footprint);
    out.medium = m.ray.medium;
    if (out.medium != voxel::Material::kAir)
        out.stop = walk::StopAt::find_end(out.medium);
    return out;
}

// Ref: Snell's law for the path of the light in the medium, Beer and Lambert's for its attenuation.
voxel::Colour Shading::through_medium(const Interaction& m, core::Vec3 direction) const noexcept {
    if (m.ray.medium == voxel::Material::kAir)
        return kWhole;
    const Medium medium = find_medium(m_view, m.ray.medium);
    const double depth_m = m.ray.hit.t * std::abs(m.ray.ray.direction.y) * m_view.voxel_m;
    const double sin2 = (1 - direction.y * direction.y) / (medium.index * medium.index);
    const double cos = std::sqrt(std::max(1e-6, 1 - sin2));
    return decay(medium.absorption_per_m, depth_m / cos) *
           static_cast<float>(1 - fresnel(std::max(direction.y, 0.0), medium.index));
}

void Shading::send_sun(const Interaction& m, voxel::Colour weight) const {
    const sky::Sky& sky = m_view.sky;
    if (!sky.sun_up())
        return;
    const auto at = m.sum.numbers.pair(to_number(m.ray, kSunPoint));
    const core::Vec3 direction = sky.sample_sun(at.u, at.v);
    const double facing = core::dot(m.surface.normal, direction);
    if (!(facing > 0) || !(direction.y > 0))
        return;
    voxel::Colour light = weight * sky.sun_light() * static_cast<float>(facing) *
                          sky.cloud_shadow(m.surface.point * m_view.voxel_m);
    if (m.ray.medium != voxel::Material::kAir)
        light = light * through_medium(m, direction);
    const bool direct = m.ray.depth == 0;
    if (!m_view.scene.quality.shadows) {
        add(direct, light, m.sum);
        if (direct)
            m.sum.sun = 1;
        return;
    }
    walk::TracedRay& out = send(m, direction, walk::RayKind::kShadow, light, kSunPoint);
    out.direct = direct;
    if (m.ray.medium != voxel::Material::kAir)
        out.stop = {m.ray.medium, false};
}

bool Shading::needs_lamp(const walk::TracedRay& ray) const noexcept {
    return m_view.lamps && !ray.lamp.looked && allows_surroundings(ray) &&
           ray.medium == voxel::Material::kAir && !is_transparent(m_view, ray.hit.attr.material);
}

double Shading::lamp_number(const walk::TracedRay& ray, const SampleSum& sum) const noexcept {
    return sum.numbers.number(to_number(ray, kLampChoice));
}

void Shading::send_lamp(const Interaction& m, voxel::Colour weight) const {
    constexpr double kInFront = 1 - 1e-6;
    const walk::LampChoice& chosen = m.ray.lamp;
    if (!(chosen.probability > 0))
        return;
    const core::Vec3 to = chosen.lamp.middle() - m.surface.point;
    const double edge = chosen.lamp.edge();
    const auto at = m.sum.numbers.pair(to_number(m.ray, kLampPoint));
    const TowardsCube found = towards_cube(to, edge, m.surface.normal, at);
    if (!(found.share > 0))
        return;
    const voxel::Colour light =
        weight * lamp_light(m_view, chosen.lamp.attr) *
        static_cast<float>(found.share / static_cast<double>(chosen.probability));
    walk::TracedRay& out = send(m, found.direction, walk::RayKind::kLamp, light, kLampPoint);
    out.direct = m.ray.depth == 0;
    out.t_max = found.distance * kInFront;
}

void Shading::send_mirror(const Interaction& m, voxel::Colour weight) const {
    const Surface& s = m.surface;
    const core::Vec3 facet = s.roughness > 0
                                 ? facet_normal(s.smooth_normal, s.roughness,
                                                m.sum.numbers.pair(to_number(m.ray, kFacet)))
                                 : s.smooth_normal;
    core::Vec3 direction = reflect(s.direction, facet);
    // A tilted facet might reflect into the face; such light leaves the face again.
    if (const double into = core::dot(direction, s.normal); into < 1e-4)
        direction = core::normalized(direction + s.normal * (1e-4 - 2 * std::min(into, 0.0)));
    send(m, direction, walk::RayKind::kMirror, weight, kFacet);
}

void Shading::shade_transparent(const Interaction& m) const {
    const auto& q = m_view.scene.quality;
    const voxel::Material beyond = m.ray.hit.attr.material == voxel::Material::kAir ||
                                           is_transparent(m_view, m.ray.hit.attr.material)
                                       ? m.ray.hit.attr.material
                                       : voxel::Material::kAir;
    const double index =
        find_medium(m_view, beyond).index / find_medium(m_view, m.ray.medium).index;
    const Surface& s = m.surface;
    core::Vec3 n = s.smooth_normal;
    if (core::dot(s.direction, n) > -1e-3)
        n = s.normal;  // seen from its back, a wave is as flat as the face
    auto reflectance =
        static_cast<float>(fresnel(std::min(1.0, -core::dot(s.direction, n)), index));
    if (!q.reflections && reflectance < 1)
        reflectance = 0;  // all of it goes in then
    const auto through = q.refraction || m.ray.medium != voxel::Material::kAir
                             ? refract(s.direction, n, index)
                             : std::nullopt;
    const bool both = splits(m.ray);
    const bool may_go_on = static_cast<int>(m.ray.depth) < std::max(q.bounces, 1);
    const bool mirror_only =
        !both && m.sum.numbers.number(to_number(m.ray, kChoice)) < static_cast<double>(reflectance);
    if (may_go_on && q.reflections && (both || mirror_only))
        send_mirror(m, both ? m.weight * reflectance : m.weight);
    if (both ? reflectance >= 1 : mirror_only)
        return;
    const voxel::Colour rest = both ? m.weight * (1 - reflectance) : m.weight;
    if (!through || !may_go_on) {
        shade_opaque({m.ray, s, rest, m.sum, m.next});
        return;
    }
    walk::TracedRay& out = send(m, *through, walk::RayKind::kRefracted, rest, kChoice);
    out.state = core::RayState(out.ray);
    out.state.start_in(m.ray.hit.voxel, m.ray.hit.level);
    out.medium = beyond;
    out.sun_counted = m.ray.sun_counted;
    out.stop =
        beyond == voxel::Material::kAir ? walk::StopAt::kSolid : walk::StopAt::find_end(beyond);
}

void Shading::continue_through(const walk::TracedRay& ray,
                               std::vector<walk::TracedRay>& next) const {
    walk::TracedRay& out = next.emplace_back(ray);
    out.state = behind(ray);
    out.state.leap(0);
    out.stream = static_cast<std::uint32_t>(core::hash64(ray.stream, 0x10000));
    out.end = walk::WalkEnd::kWaits;
    out.around = {};
    out.lamp = {};
}

void Shading::enter_medium(const walk::TracedRay& ray, std::vector<walk::TracedRay>& next) const {
    walk::TracedRay& out = next.emplace_back(ray);
    out.state = behind(ray);
    out.medium = ray.hit.attr.material;
    out.stop = walk::StopAt::find_end(out.medium);
    out.end = walk::WalkEnd::kWaits;
}

std::unique_ptr<const Shading> make_shading(const View& view) {
    if (view.scene.quality.integrator == core::Integrator::kPath)
        return std::make_unique<PathShading>(view);
    return std::make_unique<DirectShading>(view);
}

std::unique_ptr<const RayEvaluator> make_evaluator(const View& view) {
    if (view.measuring)
        return view.measuring->make_evaluator(view);
    return make_shading(view);
}

}  // namespace terravox::shade
