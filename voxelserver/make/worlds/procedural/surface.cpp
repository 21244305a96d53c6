#include "voxelserver/make/worlds/procedural/surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "voxelserver/make/worlds/procedural/noise.hpp"

namespace terravox::procedural {

using voxel::Material;
using voxel::Rgb8;

Surface::Surface(const Terrain& terrain)
    : m_column_seed(make_seed(terrain.settings().seed, 101)),
      m_patch_seed(make_seed(terrain.settings().seed, 102)),
      m_water(terrain.settings().water_level),
      m_world(terrain.settings().world_height) {}

double Surface::temperature_at(const Region& region, double height) const noexcept {
    return region.temperature - 0.6 * std::max(height - m_water, 0.0) / m_world;
}

Place Surface::place(const Region& region, std::int32_t x, std::int32_t z, double height,
                     double height_east, double height_south) const noexcept {
    const double dx = (height_east - height) / kSlopeRun;
    const double dz = (height_south - height) / kSlopeRun;
    Place out;
    out.height = height;
    out.slope = std::sqrt(dx * dx + dz * dz);
    out.temperature = temperature_at(region, height);
    out.patch = simplex(m_patch_seed, x * (1.0 / 19), z * (1.0 / 19));
    out.moisture = region.moisture + 0.03 * out.patch;
    out.hash = place_hash(m_column_seed, x, z);
    return out;
}

Rgb8 Surface::rock_colour(double temperature, double moisture, double y) noexcept {
    static constexpr std::array<Rgb8, 8> kHot{rgb(0xb5673b), rgb(0xa34f30), rgb(0xc98a55),
                                              rgb(0xd9b184), rgb(0x9c4a31), rgb(0xbf7a4a),
                                              rgb(0x8d4030), rgb(0xcf9a68)};
    static constexpr std::array<Rgb8, 4> kCool{rgb(0x8b867d), rgb(0x7d7972), rgb(0x969088),
                                               rgb(0x85807a)};
    // Layers dip a little from place to place.
    const auto layer =
        static_cast<std::int64_t>(std::floor((y + 60 * moisture + 25 * temperature) / 3));
    const std::uint64_t h = mix(static_cast<std::uint64_t>(layer));
    return mixed(kCool[h & 3], kHot[h >> 8 & 7],
                 smooth_step(0.52, 0.66, temperature) * smooth_step(0.6, 0.45, moisture));
}

Rgb8 Surface::grass_colour(const Place& p) noexcept {
    const double warm = smooth_step(0.2, 0.75, p.temperature);
    const double wet = smooth_step(0.25, 0.7, p.moisture + 0.05 * p.patch);
    const Rgb8 cold = mixed(rgb(0x8c9462), rgb(0x668a58), wet);
    const Rgb8 hot = mixed(rgb(0xb9a556), rgb(0x6d9a38), wet);
    return mixed(mixed(cold, hot, warm), rgb(0x4f6b35), 0.12 + 0.12 * p.patch);
}

Skin Surface::under_water(const Place& p, double depth) const noexcept {
    const double edge = depth + 2.5 * p.patch;
    if (p.temperature < 0.25 || edge > 16)
        return {Material::kGround, Material::kGround, rgb(0x8f887a), rgb(0x857f72), 2};
    if (p.moisture > 0.66 && edge > 2)
        return {Material::kSoil, Material::kSoil, rgb(0x5d4a35), rgb(0x5d4a35), 2};
    return {Material::kSand, Material::kSand, mixed(rgb(0xd9c892), rgb(0xb0a070), edge / 16),
            rgb(0xc9b880), 3};
}

Skin Surface::skin(const Place& p) const noexcept {
    const double above = p.height - m_water;
    if (above < 0)
        return under_water(p, -above);
    const double u = to_unit(p.hash, 0) - 0.5;
    const double temperature = p.temperature + 0.02 * u + 0.01 * p.patch;
    const double moisture = p.moisture + 0.03 * u;
    const Rgb8 soil = rgb(0x6f5339);
    const Rgb8 rock = rock_colour(p.temperature, p.moisture, p.height);
    const bool snow = temperature < 0.2;
    // Too steep for soil or snow to stay.
    const double steep = 1.05 + 0.2 * p.patch + 0.25 * u;
    if (p.slope > (snow ? steep + 0.45 : steep))
        return {Material::kRock, Material::kRock, rock, rock, 0};
    if (snow)
        return {Material::kSnow, Material::kSnow,
                mixed(rgb(0xf1f4f7), rgb(0xdfe8f0), 0.5 + 0.5 * p.patch), rgb(0xe6ebf0), 1};
    const bool desert = temperature > 0.64 && moisture < 0.43;
    const double beach = 2.4 + 1.4 * p.patch;
    if (above < beach && p.slope < 0.8 && (moisture < 0.64 || above < 0.8))
        return temperature < 0.3
                   ? Skin{Material::kGround, Material::kGround, rgb(0x979083), rgb(0x8f887a), 3}
                   : Skin{Material::kSand, Material::kSand,
                          mixed(rgb(0xdccd98), rgb(0xcdb983), 0.5 + 0.5 * p.patch), rgb(0xd2c088),
                          3};
    if (desert) {
        const Rgb8 sand = mixed(rgb(0xd9bd83), rgb(0xcf9f66),
                                smooth_step(0.64, 0.85, temperature) * (0.7 + 0.3 * p.patch));
        return {Material::kSand, Material::kSand, sand, sand, 3};
    }
    // Scree below the rocks, and where it is too cold for turf.
    const double bare = 0.75 + 0.15 * p.patch + 0.2 * u - 0.35 * smooth_step(0.3, 0.2, temperature);
    if (p.slope > bare || temperature < 0.215 + 0.02 * p.patch)
        return {Material::kGround, Material::kRock, mixed(rock, rgb(0x8d7f66), 0.35), rock, 1};
    const bool dry = temperature > 0.6 && moisture < 0.52;
    const bool cold = temperature < 0.36;
    if ((dry && p.patch > 0.5) || (cold && moisture > 0.5 && p.patch < -0.55))
        return {Material::kSoil, Material::kSoil, mixed(soil, rgb(0x7d6244), 0.5 + u), soil, 3};
    return {Material::kGrass, Material::kSoil, grass_colour(p), soil, 3};
}

}  // namespace terravox::procedural
