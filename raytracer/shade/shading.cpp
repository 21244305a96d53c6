#include "raytracer/shade/shading.hpp"

#include <algorithm>
#include <cmath>

#include "raytracer/shade/random.hpp"
#include "raytracer/walk/surroundings.hpp"

namespace terravox {
namespace {

constexpr Colour kHoleColour{1.0f, 0.0f, 0.8f};  // nothing in nature looks like it: a hole must be seen
constexpr Colour kWaterAbsorption_per_m{0.55f, 0.16f, 0.11f};
constexpr Colour kWaterGlow{0.018f, 0.075f, 0.085f};  // light that deep water gives back
constexpr double kWaterIndex = 1.333;
constexpr Colour kWhole{1, 1, 1};

std::uint64_t voxel_hash(VoxelCoord v) noexcept {
    return hash64(static_cast<std::uint32_t>(v.x) | static_cast<std::uint64_t>(static_cast<std::uint32_t>(v.z)) << 32, static_cast<std::uint32_t>(v.y));
}

// Ref: Fresnel's equations for unpolarised light entering a denser medium.
float fresnel(double cos_in) noexcept {
    const double sin2 = (1 - cos_in * cos_in) / (kWaterIndex * kWaterIndex), cos_out = std::sqrt(std::max(0.0, 1 - sin2));
    const double s = (cos_in - kWaterIndex * cos_out) / (cos_in + kWaterIndex * cos_out), p = (kWaterIndex * cos_in - cos_out) / (kWaterIndex * cos_in + cos_out);
    return static_cast<float>((s * s + p * p) / 2);
}

Vec3 refract(Vec3 d, Vec3 n) noexcept {
    const double eta = 1 / kWaterIndex, c = -dot(d, n), k = 1 - eta * eta * (1 - c * c);
    return normalized(d * eta + n * (eta * c - std::sqrt(std::max(0.0, k))));
}

Vec3 point_of(const TracedRay& ray) noexcept { return ray.ray.origin + ray.ray.direction * ray.hit.t; }

/// The start of a ray from a point on the face of a hit, into one of the two voxels at the face.
TracedRay sent_from(const TracedRay& from, Vec3 point, Vec3 direction, VoxelCoord start, RayKind kind, Colour weight) noexcept {
    TracedRay out;
    out.ray = {point, direction};
    out.state = RayState(out.ray);
    out.state.start_in(start, from.hit.level);
    out.weight = weight;
    out.sample = from.sample;
    out.kind = kind;
    return out;
}

// Corners of a face are darker where neighbours in front of it stand, smoothly over the face.
// Ref: Lysenko, "Ambient occlusion for Minecraft-like worlds", 2012 (levels from three neighbours of a corner).
float open_share(const Hit& hit, Vec3 point, std::uint8_t bits) noexcept {
    if (bits == 0) return 1;
    const int axis = axis_of(hit.face), a = (axis + 1) % 3, b = (axis + 2) % 3;
    const auto solid = [&](int i, int j) {  // 0..2 each, the middle is free
        const int place = 3 * i + j;
        return bits >> (place > 4 ? place - 1 : place) & 1;
    };
    const auto corner = [&](int i, int j) {
        const int side_a = solid(i, 1), side_b = solid(1, j);
        return side_a + side_b == 2 ? 3 : side_a + side_b + solid(i, j);
    };
    const double size = std::ldexp(1.0, hit.level);
    const double u = std::clamp(point[a] / size - hit.voxel[a], 0.0, 1.0), v = std::clamp(point[b] / size - hit.voxel[b], 0.0, 1.0);
    const double level = (corner(0, 0) * (1 - u) + corner(2, 0) * u) * (1 - v) + (corner(0, 2) * (1 - u) + corner(2, 2) * u) * v;
    return static_cast<float>(1 - 0.22 * level);
}

}  // namespace

TracedRay Shading::primary(const Ray& ray, std::uint32_t sample) const noexcept {
    TracedRay out;
    out.ray = ray;
    out.weight = kWhole;
    out.sample = sample;
    return out;
}

bool Shading::needs_surroundings(const TracedRay& ray) const noexcept {
    if (ray.kind != RayKind::kPrimary && ray.kind != RayKind::kMirror) return false;
    const bool mirrors = ray.kind == RayKind::kPrimary && m_view.scene.quality.reflections && ray.hit.attr.material == voxel::Material::kWater;
    return m_view.scene.quality.ambient_occlusion && ray.end == WalkEnd::kHit && !ray.hit.hole && ray.hit.face != Face::kNone && !mirrors;
}

void Shading::shade(const TracedRay& ray, SampleSum& sum, std::vector<TracedRay>& next) const {
    const bool hit = ray.end == WalkEnd::kHit;
    const auto add = [&](Colour c) { sum.colour = sum.colour + ray.weight * c; };
    switch (ray.kind) {
        case RayKind::kShadow:
            if (!hit) add(kWhole);
            return;
        case RayKind::kBed:
            add(bed(ray));
            return;
        case RayKind::kPrimary:
        case RayKind::kMirror: break;
    }
    if (!hit) {
        add(m_view.sky.radiance(normalized(ray.ray.direction)));
        return;
    }
    Colour weight = ray.weight;
    if (ray.kind == RayKind::kPrimary) {
        sum.t = ray.hit.t;
        // Distant things take on the colour of the air before them.
        const float haze = m_view.sky.haze(ray.hit.t * m_view.voxel_m);
        const Vec3 d = ray.ray.direction;
        add(m_view.sky.radiance(normalized({d.x, std::max(d.y, 0.0), d.z})) * haze);
        weight = weight * (1 - haze);
    }
    if (ray.hit.hole) sum.colour = sum.colour + weight * kHoleColour;
    else if (ray.hit.face == Face::kNone) return;  // the camera is inside rock
    else if (ray.kind == RayKind::kPrimary && ray.hit.attr.material == voxel::Material::kWater && m_view.scene.quality.reflections) water(ray, weight, next);
    else lit(ray, weight, sum, next);
}

void Shading::lit(const TracedRay& ray, Colour weight, SampleSum& sum, std::vector<TracedRay>& next) const {
    const Vec3 point = point_of(ray), normal = normal_of(ray.hit.face);
    const Sky& sky = m_view.sky;
    const Colour surface = weight * albedo(ray.hit);
    sum.colour = sum.colour + surface * sky.ambient(normal) * open_share(ray.hit, point, ray.around.bits);
    const double facing = dot(normal, sky.to_sun());
    if (!sky.sun_up() || !(facing > 0)) return;
    const Colour sun = surface * sky.sun_light() * static_cast<float>(facing);
    if (m_view.scene.quality.shadows) next.push_back(sent_from(ray, point, sky.to_sun(), neighbour(ray.hit.voxel, ray.hit.face), RayKind::kShadow, sun));
    else sum.colour = sum.colour + sun;
}

void Shading::water(const TracedRay& ray, Colour weight, std::vector<TracedRay>& next) const {
    const Vec3 point = point_of(ray), normal = normal_of(ray.hit.face), d = normalized(ray.ray.direction);
    const float mirrored = fresnel(std::min(1.0, -dot(d, normal)));
    next.push_back(sent_from(ray, point, d - normal * (2 * dot(d, normal)), neighbour(ray.hit.voxel, ray.hit.face), RayKind::kMirror, weight * mirrored));
    next.push_back(sent_from(ray, point, refract(d, normal), ray.hit.voxel, RayKind::kBed, weight * (1 - mirrored)));
}

// The bed, through water that swallows red first.
Colour Shading::bed(const TracedRay& ray) const {
    constexpr double kBottomless_m = 1000, kWayBack = 0.8;  // light comes down, and goes up a little straighter
    const bool hit = ray.end == WalkEnd::kHit;
    const double depth_m = hit ? ray.hit.t * m_view.voxel_m : kBottomless_m;
    const auto through = [&](float per_m) { return static_cast<float>(det::exp(-static_cast<double>(per_m) * depth_m * (1 + kWayBack))); };
    const Colour left{through(kWaterAbsorption_per_m.r), through(kWaterAbsorption_per_m.g), through(kWaterAbsorption_per_m.b)};
    const Sky& sky = m_view.sky;
    const bool seen = hit && ray.hit.face != Face::kNone && !ray.hit.hole;
    const Colour ground = seen ? albedo(ray.hit) * (sky.ambient({0, 1, 0}) + sky.sun_light() * 0.5f) : Colour{};
    const Colour glow = kWaterGlow * (sky.ambient({0, 1, 0}) + sky.sun_light() * static_cast<float>(std::max(0.0, sky.to_sun().y)));
    return ground * left + glow * Colour{1 - left.r, 1 - left.g, 1 - left.b};
}

Colour Shading::albedo(const Hit& hit) const {
    const auto& entry = m_view.palette.of(hit.attr.material);
    const auto& q = m_view.scene.quality;
    Colour colour = to_linear(entry.colour);
    if (hit.attr.has_colour() && q.colour != "material")
        colour = mix(colour, to_linear(hit.attr.colour), q.colour == "true" ? 1.0f : static_cast<float>(q.colour_mix));
    // The mean of the many voxels that a coarse one stands for varies less.
    const auto variation = static_cast<float>(std::ldexp(static_cast<double>(entry.variation), -hit.level));
    const auto wobble = static_cast<float>(unit_from(voxel_hash(hit.voxel)) - 0.5) * 2 * variation;
    return colour * (1 + wobble);
}

}  // namespace terravox
