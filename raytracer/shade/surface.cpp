#include "raytracer/shade/surface.hpp"

#include <algorithm>
#include <cmath>

#include "raytracer/shade/random.hpp"

namespace terravox {
namespace {

std::uint64_t voxel_hash(VoxelCoord v) noexcept {
    return hash64(static_cast<std::uint32_t>(v.x) | static_cast<std::uint64_t>(static_cast<std::uint32_t>(v.z)) << 32, static_cast<std::uint32_t>(v.y));
}

Colour base_colour(const View& view, const Hit& hit) {
    const auto& entry = view.palette.of(hit.attr.material);
    const auto& q = view.scene.quality;
    Colour colour = to_linear(entry.colour);
    if (hit.attr.has_colour() && q.colour != "material")
        colour = mix(colour, to_linear(hit.attr.colour), q.colour == "true" ? 1.0f : static_cast<float>(q.colour_mix));
    // The mean of the many voxels that a coarse one stands for varies less.
    const auto variation = static_cast<float>(std::ldexp(static_cast<double>(entry.variation), -hit.level));
    const auto wobble = static_cast<float>(unit_from(voxel_hash(hit.voxel)) - 0.5) * 2 * variation;
    return colour * (1 + wobble);
}

}  // namespace

Medium medium_of(const View&, voxel::Material material) noexcept {
    if (material == voxel::Material::kAir) return {};
    return {{0.55f, 0.16f, 0.11f}, {0.018f, 0.075f, 0.085f}, 1.333};
}

bool is_transparent(const View&, voxel::Material material) noexcept { return material == voxel::Material::kWater; }

bool has_holes(const View&, voxel::Material) noexcept { return false; }

Surface surface_at(const View& view, const TracedRay& ray) {
    Surface out;
    out.point = ray.ray.origin + ray.ray.direction * ray.hit.t;
    out.normal = out.smooth_normal = normal_of(ray.hit.face);
    out.direction = ray.ray.direction;
    out.transparent = is_transparent(view, ray.hit.attr.material);
    out.index = 1.333;
    out.albedo = base_colour(view, ray.hit);
    return out;
}

// Smoothly over the face.
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

}  // namespace terravox
