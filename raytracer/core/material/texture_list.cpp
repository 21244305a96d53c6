#include "raytracer/core/material/texture_list.hpp"

#include <cmath>

#include "raytracer/core/base/random.hpp"

namespace terravox::material {
namespace {

float smooth(float t) noexcept {
    return t * t * (3 - 2 * t);
}

// The shorter way round the canvas.
float around(float d) noexcept {
    constexpr float kEdge = kTexels;
    return d > kEdge / 2 ? d - kEdge : d < -kEdge / 2 ? d + kEdge : d;
}

}  // namespace

float chance(int a, int b, std::uint64_t seed) noexcept {
    return static_cast<float>(core::unit_from(core::hash64(
        static_cast<std::uint32_t>(a) | static_cast<std::uint64_t>(static_cast<std::uint32_t>(b))
                                            << 32,
        seed)));
}

float grain(int s, int t, std::uint64_t seed) noexcept {
    return 2 * chance(s & (kTexels - 1), t & (kTexels - 1), seed) - 1;
}

float cloud(int s, int t, int cells, std::uint64_t seed) noexcept {
    const int size = kTexels / cells;
    s &= kTexels - 1;
    t &= kTexels - 1;
    const int i = s / size;
    const int j = t / size;
    const auto corner = [&](int di, int dj) {
        return 2 * chance((i + di) % cells, (j + dj) % cells, seed) - 1;
    };
    const auto within = [&](int v) {
        return smooth((static_cast<float>(v % size) + 0.5f) / static_cast<float>(size));
    };
    const float x = within(s);
    const float y = within(t);
    const float low = corner(0, 0) * (1 - x) + corner(1, 0) * x;
    const float high = corner(0, 1) * (1 - x) + corner(1, 1) * x;
    return low * (1 - y) + high * y;
}

float wave(float turns) noexcept {
    const float x = turns - std::floor(turns + 0.5f);  // [-1/2, 1/2)
    const float a = 4 * (std::fabs(x) - 0.25f);        // [-1, 1], -1 at whole turns
    return -a * (2 - std::fabs(a));
}

voxel::Colour tint(float brightness, float warm) noexcept {
    return {brightness * (1 + 0.5f * warm), brightness * (1 + 0.12f * warm),
            brightness * (1 - 0.7f * warm)};
}

Stones::Stones(int per_edge, std::uint64_t seed) {
    const float size = static_cast<float>(kTexels) / static_cast<float>(per_edge);
    for (int j = 0; j < per_edge; ++j)
        for (int i = 0; i < per_edge; ++i)
            m_points.push_back(
                {(static_cast<float>(i) + 0.1f + 0.8f * chance(i, j, seed)) * size,
                 (static_cast<float>(j) + 0.1f + 0.8f * chance(i, j, seed + 1)) * size});
}

Stones::At Stones::at(int s, int t) const noexcept {
    float nearest = 1e9f;
    float second = 1e9f;
    At out;
    for (std::size_t i = 0; i < m_points.size(); ++i) {
        const float ds = around(static_cast<float>(s) + 0.5f - m_points[i][0]);
        const float dt = around(static_cast<float>(t) + 0.5f - m_points[i][1]);
        const float far = std::sqrt(ds * ds + dt * dt);
        if (far < nearest) {
            second = nearest;
            nearest = far;
            out.id = static_cast<int>(i);
            out.up = dt;
        } else if (far < second)
            second = far;
    }
    out.edge = (second - nearest) / 2;
    return out;
}

namespace {

constexpr Drawing kNothing{};
constexpr Drawing kGrassTop{draw_grass_top, 6, Turn::kAny};
constexpr Drawing kGrassSide{draw_grass_side, 6, Turn::kMirror};
constexpr Drawing kSoil{draw_soil, 8, Turn::kMirror, false, true};
constexpr Drawing kGravel{draw_gravel, 4, Turn::kAny};
constexpr Drawing kRockTop{draw_rock_top, 6, Turn::kAny};
constexpr Drawing kRockSide{draw_rock_side, 16, Turn::kMirror, false, true};
constexpr Drawing kSand{draw_sand, 4, Turn::kNone};
constexpr Drawing kSnow{draw_snow, 4, Turn::kAny};
constexpr Drawing kTufts{draw_tufts, 6, Turn::kMirror};
constexpr Drawing kBush{draw_bush, 6, Turn::kAny};
constexpr Drawing kFoliage{draw_foliage, 6, Turn::kAny};
constexpr Drawing kHedge{draw_hedge, 4, Turn::kAny};
constexpr Drawing kBark{draw_bark, 4, Turn::kMirror};
constexpr Drawing kRings{draw_rings, 2, Turn::kAny};
constexpr Drawing kAsphalt{draw_asphalt, 6, Turn::kAny};
constexpr Drawing kSlabs{draw_slabs, 4, Turn::kNone, true};
constexpr Drawing kBallast{draw_ballast, 4, Turn::kAny};
constexpr Drawing kMasonry{draw_masonry, 4, Turn::kMirror, true};
constexpr Drawing kPlanks{draw_planks, 4, Turn::kMirror, true};
constexpr Drawing kPaving{draw_paving, 4, Turn::kNone, true};
constexpr Drawing kPlaster{draw_plaster, 4, Turn::kMirror};
constexpr Drawing kLattice{draw_lattice, 2, Turn::kMirror, true};
constexpr Drawing kWireSide{draw_wire_side, 2, Turn::kMirror};
constexpr Drawing kWireTop{draw_wire_top, 1, Turn::kNone};
constexpr Drawing kPanel{draw_panel, 4, Turn::kAny};
constexpr Drawing kTilesTop{draw_tiles, 8, Turn::kSlope, true};
constexpr Drawing kTilesSide{draw_tiles, 4, Turn::kMirror, true};
constexpr Drawing kSlateTop{draw_slate, 8, Turn::kSlope, true};
constexpr Drawing kSlateSide{draw_slate, 4, Turn::kMirror, true};
constexpr Drawing kFlatRoof{draw_flat_roof, 4, Turn::kNone, true};

constexpr std::array kTextures = {
    Texture{"none", kNothing, kNothing, kNothing},
    Texture{"grass", kGrassTop, kGrassSide, kSoil, false, false, voxel::Material::kSoil},
    Texture{"soil", kSoil, kSoil, kSoil},
    Texture{"gravel", kGravel, kGravel, kGravel},
    Texture{"rock", kRockTop, kRockSide, kRockTop},
    Texture{"sand", kSand, kSand, kSand},
    Texture{"snow", kSnow, kSnow, kSnow},
    Texture{"tufts", kBush, kTufts, kBush},
    Texture{"bush", kBush, kBush, kBush},
    Texture{"foliage", kFoliage, kFoliage, kFoliage},
    Texture{"hedge", kHedge, kHedge, kHedge},
    Texture{"bark", kRings, kBark, kRings},
    Texture{"asphalt", kAsphalt, kAsphalt, kAsphalt},
    Texture{"slabs", kSlabs, kSlabs, kSlabs},
    Texture{"ballast", kBallast, kBallast, kBallast},
    Texture{"bridge", kPaving, kMasonry, kMasonry},
    Texture{"masonry", kMasonry, kMasonry, kMasonry},
    Texture{"planks", kPlanks, kPlanks, kPlanks},
    Texture{"plaster", kPlaster, kPlaster, kPlaster},
    Texture{"house", kPlaster, kPlaster, kPlaster, true},
    Texture{"lattice", kLattice, kLattice, kLattice},
    Texture{"wire", kWireTop, kWireSide, kWireTop},
    Texture{"panel", kPanel, kPanel, kPanel},
    Texture{"tiles", kTilesTop, kTilesSide, kTilesSide},
    Texture{"slate", kSlateTop, kSlateSide, kSlateSide},
    Texture{"flat_roof", kFlatRoof, kPanel, kFlatRoof},
    Texture{"water", kNothing, kNothing, kNothing, false, true},
};

}  // namespace

std::span<const Texture> textures() noexcept {
    return kTextures;
}

int texture_number(std::string_view name) noexcept {
    for (std::size_t i = 0; i < kTextures.size(); ++i)
        if (kTextures[i].name == name)
            return static_cast<int>(i);
    return -1;
}

}  // namespace terravox::material
