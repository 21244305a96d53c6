#include "raytracer/shade/shader.hpp"

#include <cmath>
#include <limits>

#include "raytracer/shade/random.hpp"

namespace terravox {
namespace {

constexpr Colour kHoleColour{1.0f, 0.0f, 0.8f};  // nothing in nature looks like it: a hole must be seen
constexpr Colour kWaterAbsorption_per_m{0.55f, 0.16f, 0.11f};
constexpr Colour kWaterGlow{0.018f, 0.075f, 0.085f};  // light that deep water gives back
constexpr double kWaterIndex = 1.333;

VoxelCoord neighbour(VoxelCoord v, Face face) noexcept {
    const int s = sign_of(face);
    switch (axis_of(face)) {
        case 0: v.x += s; break;
        case 1: v.y += s; break;
        default: v.z += s; break;
    }
    return v;
}

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

}  // namespace

Shader::Shader(const View& view, BlockManager& blocks)
    : m_view(view), m_reader(blocks, view.scene.quality.level), m_walker(m_reader, view.bounds), m_scale(static_cast<double>(1 << view.scene.quality.level)) {}

Ray Shader::to_level(const Ray& ray) const noexcept { return {ray.origin * (1 / m_scale), ray.direction * (1 / m_scale)}; }

PixelSample Shader::pixel(int x, int y) {
    const int samples = m_view.scene.quality.samples;
    const auto id = static_cast<std::uint64_t>(y) << 32 | static_cast<std::uint32_t>(x);
    double r = 0, g = 0, b = 0, depth = 0;
    int hits = 0;
    for (int s = 0; s < samples; ++s) {
        // Ref: Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018 (R2), shifted by a number of the pixel's own.
        const double shift_u = samples == 1 ? 0 : unit_from(hash64(id, 1)), shift_v = samples == 1 ? 0 : unit_from(hash64(id, 2));
        double u = 0.5 + 0.7548776662466927 * s + shift_u, v = 0.5 + 0.5698402909980532 * s + shift_v;
        u -= std::floor(u), v -= std::floor(v);
        double t = 0;
        bool found = false;
        const Colour c = trace(m_view.camera.ray(x + u, y + v), t, found);
        r += c.r, g += c.g, b += c.b;
        if (found) depth += t, ++hits;
    }
    const double n = samples;
    return {{static_cast<float>(r / n), static_cast<float>(g / n), static_cast<float>(b / n)},
            static_cast<float>(hits / n),
            hits > 0 ? static_cast<float>(depth / hits * m_view.voxel_m) : std::numeric_limits<float>::infinity()};
}

Colour Shader::trace(const Ray& ray, double& t, bool& found) {
    const Ray local = to_level(ray);
    const auto hit = m_walker.first_hit(local);
    found = hit.has_value();
    if (!hit) return m_view.sky.radiance(ray.direction);
    t = hit->t;
    const Colour colour = shade(local, *hit, m_view.scene.quality.reflections);
    // Distant things take on the colour of the air before them.
    const Vec3 level = normalized({ray.direction.x, std::max(ray.direction.y, 0.0), ray.direction.z});
    return mix(colour, m_view.sky.radiance(level), m_view.sky.haze(t * m_view.voxel_m));
}

// `ray` in level voxels; its direction has the length of one level-0 voxel, so t counts level-0 voxels.
Colour Shader::shade(const Ray& ray, const Hit& hit, bool mirrors) {
    if (hit.hole) {
        ++m_hole_rays;
        return kHoleColour;
    }
    if (hit.face == Face::kNone) return {};  // the camera is inside rock
    if (hit.attr.material == voxel::Material::kWater && mirrors) return water(ray, hit);
    return lit(ray, hit);
}

Colour Shader::lit(const Ray& ray, const Hit& hit) {
    const Vec3 point = ray.origin + ray.direction * hit.t, normal = normal_of(hit.face);
    const Sky& sky = m_view.sky;
    const double facing = dot(normal, sky.to_sun());
    Colour light = sky.ambient(normal) * occlusion(hit, point);
    if (sky.sun_up() && facing > 0 && !in_shadow(point, neighbour(hit.voxel, hit.face))) light = light + sky.sun_light() * static_cast<float>(facing);
    return albedo(hit) * light;
}

Colour Shader::water(const Ray& ray, const Hit& hit) {
    const Vec3 point = ray.origin + ray.direction * hit.t, normal = normal_of(hit.face), d = normalized(ray.direction);
    const float mirrored = fresnel(std::min(1.0, -dot(d, normal)));
    const double unit = length(ray.direction);

    // Step 1: what the surface mirrors.
    const Ray up{point, (d - normal * (2 * dot(d, normal))) * unit};
    const auto above = m_walker.first_hit_from(up, neighbour(hit.voxel, hit.face));
    const Colour reflected = above ? shade(up, *above, false) : m_view.sky.radiance(normalized(up.direction));

    // Step 2: the bed, through water that swallows red first.
    const Ray down{point, refract(d, normal) * unit};
    const auto bed = m_walker.first_hit_from(down, hit.voxel, StopAt::kNotWater);
    const double depth_m = bed ? bed->t * m_view.voxel_m : 1000;
    const auto through = [&](float per_m) { return static_cast<float>(det::exp(-static_cast<double>(per_m) * depth_m * 1.8)); };
    const Colour left{through(kWaterAbsorption_per_m.r), through(kWaterAbsorption_per_m.g), through(kWaterAbsorption_per_m.b)};
    const Colour ground = bed && bed->face != Face::kNone && !bed->hole ? albedo(*bed) * (m_view.sky.ambient({0, 1, 0}) + m_view.sky.sun_light() * 0.5f) : Colour{};
    const Colour glow = kWaterGlow * (m_view.sky.ambient({0, 1, 0}) + m_view.sky.sun_light() * static_cast<float>(std::max(0.0, m_view.sky.to_sun().y)));
    const Colour body{ground.r * left.r + glow.r * (1 - left.r), ground.g * left.g + glow.g * (1 - left.g), ground.b * left.b + glow.b * (1 - left.b)};
    return mix(body, reflected, mirrored);
}

Colour Shader::albedo(const Hit& hit) const {
    const auto& entry = m_view.palette.of(hit.attr.material);
    const auto& q = m_view.scene.quality;
    Colour colour = to_linear(entry.colour);
    if (hit.attr.has_colour() && q.colour != "material")
        colour = mix(colour, to_linear(hit.attr.colour), q.colour == "true" ? 1.0f : static_cast<float>(q.colour_mix));
    const auto wobble = static_cast<float>(unit_from(voxel_hash(hit.voxel)) - 0.5) * 2 * entry.variation;
    return colour * (1 + wobble);
}

// Corners of a face are darker where neighbours in front of it stand, smoothly over the face.
// Ref: Lysenko, "Ambient occlusion for Minecraft-like worlds", 2012 (levels from three neighbours of a corner).
float Shader::occlusion(const Hit& hit, Vec3 point) {
    if (!m_view.scene.quality.ambient_occlusion) return 1;
    const VoxelCoord front = neighbour(hit.voxel, hit.face);
    const int axis = axis_of(hit.face), a = (axis + 1) % 3, b = (axis + 2) % 3;
    const auto solid = [&](int da, int db) {
        std::int32_t c[3] = {front.x, front.y, front.z};
        c[a] += da, c[b] += db;
        return m_reader.solid(c[0], c[1], c[2]) ? 1 : 0;
    };
    int around[3][3];
    for (int i = -1; i <= 1; ++i)
        for (int j = -1; j <= 1; ++j) around[i + 1][j + 1] = i == 0 && j == 0 ? 0 : solid(i, j);
    const auto corner = [&](int i, int j) {
        const int side_a = around[i][1], side_b = around[1][j];
        return side_a + side_b == 2 ? 3 : side_a + side_b + around[i][j];
    };
    const double u = std::clamp(point[a] - hit.voxel[a], 0.0, 1.0), v = std::clamp(point[b] - hit.voxel[b], 0.0, 1.0);
    const double level = (corner(0, 0) * (1 - u) + corner(2, 0) * u) * (1 - v) + (corner(0, 2) * (1 - u) + corner(2, 2) * u) * v;
    return static_cast<float>(1 - 0.22 * level);
}

bool Shader::in_shadow(Vec3 point, VoxelCoord outside) {
    if (!m_view.scene.quality.shadows) return false;
    return m_walker.first_hit_from({point, m_view.sky.to_sun()}, outside).has_value();
}

}  // namespace terravox
