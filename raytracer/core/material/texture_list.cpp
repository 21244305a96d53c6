#include "raytracer/core/material/texture_list.hpp"

#include <array>

namespace terravox::material {
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
