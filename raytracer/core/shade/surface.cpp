#include "raytracer/core/shade/surface.hpp"

#include <algorithm>

#include "common/util/det_math.hpp"
#include "raytracer/core/base/random.hpp"

namespace terravox::shade {
namespace {

std::uint64_t voxel_hash(core::VoxelCoord v) noexcept {
    return core::hash64(static_cast<std::uint32_t>(v.x) |
                            static_cast<std::uint64_t>(static_cast<std::uint32_t>(v.z)) << 32,
                        static_cast<std::uint32_t>(v.y));
}

/// How far a photo's colour can be trusted to be that of a voxel, and not its neighbour's: a photo
/// that is a metre off, or leans, shows the lake on its shore, and what stands next to a wall on
/// top of it. Returned as a share of the scene's colour_mix.
float believed(voxel::Material material, voxel::Colour photo) noexcept {
    using voxel::Material;
    if (material == Material::kWall)
        return 0;
    if (material != Material::kGround && material != Material::kGrass && !voxel::is_plant(material))
        return 1;
    // Neither plants nor bare ground are mostly blue; shade is only bluish.
    constexpr float kShade = 1.75f;
    constexpr float kWater = 2.5f;
    constexpr float kBlack = 1e-3f;
    if (photo.b < photo.g)
        return 1;
    return 1 - std::clamp((photo.b / std::max(photo.r, kBlack) - kShade) / (kWater - kShade), 0.0f,
                          1.0f);
}

voxel::Colour base_colour(const View& view, const material::MaterialAppearance& appearance,
                          const walk::Hit& hit) {
    const auto& q = view.scene.quality;
    voxel::Colour colour = appearance.colour;
    if (hit.attr.has_colour() && q.colour != core::VoxelColour::kMaterial) {
        const voxel::Colour photo = voxel::to_linear(hit.attr.colour);
        colour =
            voxel::mix(colour, photo,
                       q.colour == core::VoxelColour::kTrue
                           ? 1.0f
                           : static_cast<float>(q.colour_mix) * believed(hit.attr.material, photo));
    }
    if (hit.attr.is_tinted() && q.colour != core::VoxelColour::kMaterial)
        colour = voxel::to_linear(hit.attr.colour);
    // The mean of the many voxels that a coarse one stands for varies less.
    const auto variation =
        static_cast<float>(static_cast<double>(appearance.variation) * det::exp2_int(-hit.level));
    const auto wobble =
        static_cast<float>(core::unit_from(voxel_hash(hit.voxel)) - 0.5) * 2 * variation;
    return colour * (1 + wobble);
}

// A lamp shines in its own colour: its brightest channel is as bright as the material specifies.
voxel::Colour to_hue(const voxel::VoxelAttr& attr) noexcept {
    if (attr.material != voxel::Material::kLamp || !attr.has_colour())
        return {1, 1, 1};
    const voxel::Colour own = voxel::to_linear(attr.colour);
    return own * (1 / std::max({own.r, own.g, own.b, 1e-3f}));
}

// Where on its face a point lies, along an axis.
double part_of_voxel(double point, int level, std::int32_t voxel) noexcept {
    constexpr double kBelowOne = 0x1.fffffffffffffp-1;
    return std::clamp(point * det::exp2_int(-level) - voxel, 0.0, kBelowOne);
}

material::Texel texel_at(const View& view, const walk::TracedRay& ray, core::Vec3 point,
                         const material::MaterialAppearance& appearance) noexcept {
    const walk::Hit& hit = ray.hit;
    if (!view.scene.quality.textures) {
        material::Texel plain;
        // Windows are drawn; without drawings none is lit.
        if (hit.attr.material == voxel::Material::kWall)
            plain.emission = 0;
        return plain;
    }
    if (appearance.kind == material::Kind::kSolid && appearance.texture == 0)
        return {};
    const int axis = core::to_axis(hit.face);
    const int a = (axis + 1) % 3;
    const int b = (axis + 2) % 3;
    material::FacePoint at;
    at.voxel = hit.voxel;
    at.level = hit.level;
    at.face = hit.face;
    at.u = part_of_voxel(point[a], hit.level, hit.voxel[a]);
    at.v = part_of_voxel(point[b], hit.level, hit.voxel[b]);
    at.footprint = static_cast<double>(footprint_at(ray));
    at.around = ray.around.bits;
    at.voxel_m = view.voxel_m;
    at.night = view.night;
    return view.materials->texel(hit.attr.material, at);
}

}  // namespace

Medium find_medium(const View& view, voxel::Material material) noexcept {
    if (material == voxel::Material::kAir)
        return {};
    const material::MaterialAppearance& appearance = view.materials->appearance(material);
    return {appearance.absorption_per_m, appearance.glow, static_cast<double>(appearance.index)};
}

voxel::Colour lamp_light(const View& view, const voxel::VoxelAttr& attr) noexcept {
    return view.materials->appearance(attr.material).emission * to_hue(attr);
}

bool is_transparent(const View& view, voxel::Material material) noexcept {
    const material::Kind kind = view.materials->appearance(material).kind;
    return kind == material::Kind::kWater || kind == material::Kind::kGlass;
}

bool has_holes(const View& view, voxel::Material material) noexcept {
    return view.materials->appearance(material).kind == material::Kind::kLeaves &&
           view.scene.quality.cut_outs;
}

Surface surface_at(const View& view, const walk::TracedRay& ray) {
    Surface out;
    out.point = ray.ray.origin + ray.ray.direction * ray.hit.t;
    out.normal = out.smooth_normal = core::to_normal(ray.hit.face);
    out.direction = ray.ray.direction;
    if (ray.hit.attr.material == voxel::Material::kAir)
        return out;  // out of a medium
    const material::MaterialAppearance& appearance =
        view.materials->appearance(ray.hit.attr.material);
    const material::Texel texel = texel_at(view, ray, out.point, appearance);
    out.albedo = base_colour(view, appearance, ray.hit) * texel.ratio * (1 - texel.own_share) +
                 texel.own * texel.own_share;
    out.emission = appearance.emission * texel.emission * to_hue(ray.hit.attr);
    out.leaves = appearance.kind == material::Kind::kLeaves && view.scene.quality.cut_outs;
    out.opacity = out.leaves ? texel.opacity : 1;
    out.transparent =
        appearance.kind == material::Kind::kWater || appearance.kind == material::Kind::kGlass;
    out.polish = out.transparent ? 0 : appearance.reflects ? 1 : texel.gloss;
    out.roughness = appearance.roughness;
    out.index = static_cast<double>(appearance.index);
    if (ray.hit.face == core::Face::kTop && (texel.tilt[0] != 0 || texel.tilt[1] != 0))
        out.smooth_normal = core::normalized(
            {static_cast<double>(texel.tilt[0]), 1, static_cast<double>(texel.tilt[1])});
    return out;
}

bool shows_slope(const View& view, const walk::Hit& hit) noexcept {
    if (hit.face != core::Face::kTop || hit.level != 0 || !view.scene.quality.textures)
        return false;
    return voxel::is_sloped_roof(hit.attr.material);
}

// Smoothly over the face.
// Ref: Lysenko, "Ambient occlusion for Minecraft-like worlds", 2012 (levels from three neighbours
// of a corner).
float open_share(const walk::Hit& hit, core::Vec3 point, std::uint8_t bits) noexcept {
    if (bits == 0)
        return 1;
    const int axis = core::to_axis(hit.face);
    const int a = (axis + 1) % 3;
    const int b = (axis + 2) % 3;
    const auto solid = [&](int i, int j) {  // 0..2 each, the middle is free
        const int place = 3 * i + j;
        return bits >> (place > 4 ? place - 1 : place) & 1;
    };
    const auto corner = [&](int i, int j) {
        const int side_a = solid(i, 1);
        const int side_b = solid(1, j);
        return side_a + side_b == 2 ? 3 : side_a + side_b + solid(i, j);
    };
    const double size = det::exp2_int(hit.level);
    const double u = std::clamp(point[a] / size - hit.voxel[a], 0.0, 1.0);
    const double v = std::clamp(point[b] / size - hit.voxel[b], 0.0, 1.0);
    const double level = (corner(0, 0) * (1 - u) + corner(2, 0) * u) * (1 - v) +
                         (corner(0, 2) * (1 - u) + corner(2, 2) * u) * v;
    return static_cast<float>(1 - 0.22 * level);
}

}  // namespace terravox::shade
