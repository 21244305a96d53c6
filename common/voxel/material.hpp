#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>

namespace terravox::voxel {

/// The material of a voxel, after classification. The numbers are part of the box format
/// (docs/formats/box.md): never renumber.
enum class Material : std::uint8_t {
    kAir = 0,
    kRock = 1,
    kSoil = 2,
    kGround = 3,  ///< bare or unknown ground surface
    kGrass = 4,
    kLowVegetation = 5,
    kMediumVegetation = 6,
    kHighVegetation = 7,
    kWall = 8,
    kRoof = 9,
    kOrangeRoof = 10,
    kGreyRoof = 11,
    kFlatRoof = 12,
    kWater = 13,
    kBridge = 14,
    kRoad = 15,
    kConcrete = 16,
    kRail = 17,
    kWire = 18,
    kTower = 19,
    kObject = 20,  ///< street furniture, vehicles and other unclassified things above the ground
    kSand = 21,
    kSnow = 22,
    kUnknown = 23,  ///< a class that is in no table: kept visible
    kTrunk = 24,    ///< of a tree, from the ground to the crown
    kGlass = 25,
    kIce = 26,
    kLava = 27,     ///< emits light
    kLamp = 28,     ///< emits light in its voxel's own colour
    kWood = 29,     ///< planks
    kMasonry = 30,  ///< laid stones or bricks
    kPlain = 31,    ///< of one colour, without a pattern: cloth, plaster, cast and polished things
    kSolarPanel = 32,
};

/// How a voxel interacts with light. Exporters and the tracer's defaults follow it; the tracer's
/// own appearance of a material is in config/materials.toml.
enum class Optics : std::uint8_t {
    kAir,
    kOpaque,
    kLeaves,  ///< opaque with gaps: leaves, wires
    kWater,
    kGlass,
    kIce,
};

/// How a material is treated when eight voxels are merged into one (coarse_rule.hpp).
enum class Grain : std::uint8_t {
    kTerrain,  ///< ground materials; also all hidden voxels, whose material is unknown
    /// Walls, roofs, bridges, towers, planks, bricks, cloth: often one voxel thick with air behind.
    kShell,
    kObject,  ///< opaque, often a lone voxel
    kWater,   ///< water and ice
    kSparse,  ///< leaves, trunks, wires and panes; a trunk that grew would darken its wood
};

/// A numeric block of Minecraft before version 1.13.
struct OldBlock {
    std::uint8_t id = 0;
    std::uint8_t data = 0;  ///< [0, 15]
};

/// All properties that depend on the material alone.
struct MaterialTraits {
    Material material;
    std::string_view name;  ///< in files, flags and messages
    Optics optics;
    Grain grain;
    /// The block in the protocol of the first system (docs/formats/http.md). Blocks that the first
    /// system itself used are kept.
    OldBlock old_block;
    /// The block in an exported Minecraft world, with the properties that matter. Each block stands
    /// for one material only.
    std::string_view block;
    int glow = 0;  ///< strength of its light emission, in steps of MagicaVoxel; 0: none
};

/// All materials in numerical order. To add one, add an enumerator, a row here, and a row of
/// config/materials.toml.
inline constexpr MaterialTraits kMaterialTraits[] = {
    {Material::kAir, "air", Optics::kAir, Grain::kSparse, {0}, "air"},
    {Material::kRock, "rock", Optics::kOpaque, Grain::kTerrain, {1}, "stone"},
    {Material::kSoil, "soil", Optics::kOpaque, Grain::kTerrain, {3}, "coarse_dirt"},
    {Material::kGround, "ground", Optics::kOpaque, Grain::kTerrain, {3}, "gravel"},
    {Material::kGrass, "grass", Optics::kOpaque, Grain::kTerrain, {2}, "grass_block"},
    {Material::kLowVegetation,
     "low_vegetation",
     Optics::kLeaves,
     Grain::kSparse,
     {2},
     "mangrove_leaves[persistent=true,distance=7]"},
    {Material::kMediumVegetation,
     "medium_vegetation",
     Optics::kLeaves,
     Grain::kSparse,
     {18, 1},
     "azalea_leaves[persistent=true,distance=7]"},
    {Material::kHighVegetation,
     "high_vegetation",
     Optics::kLeaves,
     Grain::kSparse,
     {18, 0},
     "oak_leaves[persistent=true,distance=7]"},
    {Material::kWall, "wall", Optics::kOpaque, Grain::kShell, {35, 8}, "white_terracotta"},
    {Material::kRoof, "roof", Optics::kOpaque, Grain::kShell, {35, 8}, "bricks"},
    {Material::kOrangeRoof, "orange_roof", Optics::kOpaque, Grain::kShell, {35, 1}, "terracotta"},
    {Material::kGreyRoof, "grey_roof", Optics::kOpaque, Grain::kShell, {35, 8}, "deepslate_tiles"},
    {Material::kFlatRoof,
     "flat_roof",
     Optics::kOpaque,
     Grain::kShell,
     {35, 0},
     "polished_andesite"},
    {Material::kWater, "water", Optics::kWater, Grain::kWater, {9}, "water[level=0]"},
    {Material::kBridge, "bridge", Optics::kOpaque, Grain::kShell, {98}, "stone_bricks"},
    {Material::kRoad, "road", Optics::kOpaque, Grain::kTerrain, {1}, "gray_concrete"},
    {Material::kConcrete, "concrete", Optics::kOpaque, Grain::kTerrain, {35, 8}, "smooth_stone"},
    // The gravel under rails, since rails are not full blocks.
    {Material::kRail, "rail", Optics::kOpaque, Grain::kTerrain, {13}, "cobbled_deepslate"},
    {Material::kWire, "wire", Optics::kLeaves, Grain::kSparse, {101}, "iron_bars"},
    {Material::kTower, "tower", Optics::kOpaque, Grain::kShell, {42}, "iron_block"},
    {Material::kObject, "object", Optics::kOpaque, Grain::kObject, {35, 7}, "white_concrete"},
    {Material::kSand, "sand", Optics::kOpaque, Grain::kTerrain, {12}, "sand"},
    {Material::kSnow, "snow", Optics::kOpaque, Grain::kTerrain, {80}, "snow_block"},
    // Magenta in every format, so that it is noticed.
    {Material::kUnknown,
     "unknown",
     Optics::kOpaque,
     Grain::kObject,
     {35, 2},
     "magenta_glazed_terracotta"},
    {Material::kTrunk, "trunk", Optics::kOpaque, Grain::kSparse, {17}, "oak_log"},
    {Material::kGlass, "glass", Optics::kGlass, Grain::kSparse, {20}, "glass"},
    {Material::kIce, "ice", Optics::kIce, Grain::kWater, {79}, "packed_ice"},
    {Material::kLava, "lava", Optics::kOpaque, Grain::kTerrain, {11}, "lava[level=0]", 1},
    {Material::kLamp, "lamp", Optics::kOpaque, Grain::kObject, {89}, "glowstone", 2},
    {Material::kWood, "wood", Optics::kOpaque, Grain::kShell, {5}, "oak_planks"},
    {Material::kMasonry, "masonry", Optics::kOpaque, Grain::kShell, {98}, "cobblestone"},
    {Material::kPlain, "plain", Optics::kOpaque, Grain::kShell, {35, 0}, "light_gray_wool"},
    {Material::kSolarPanel,
     "solar_panel",
     Optics::kOpaque,
     Grain::kShell,
     {151},
     "daylight_detector[inverted=false]"},
};
inline constexpr int kMaterialCount = static_cast<int>(std::size(kMaterialTraits));
static_assert(
    [] {
        for (std::size_t i = 0; i < std::size(kMaterialTraits); ++i)
            if (static_cast<std::size_t>(kMaterialTraits[i].material) != i)
                return false;
        return true;
    }(),
    "kMaterialTraits has a row for each material, in the order of their numbers");

/// The index of a material in tables with an entry for each.
/// @return that of kUnknown for a number without a row; [0, kMaterialCount)
[[nodiscard]] constexpr std::size_t material_index(Material material) noexcept {
    const auto index = static_cast<std::size_t>(material);
    return index < std::size(kMaterialTraits) ? index
                                              : static_cast<std::size_t>(Material::kUnknown);
}

/// @return the traits of kUnknown for a number without a row
[[nodiscard]] constexpr const MaterialTraits& find_traits(Material material) noexcept {
    return kMaterialTraits[material_index(material)];
}

[[nodiscard]] constexpr std::string_view material_name(Material material) noexcept {
    return find_traits(material).name;
}
[[nodiscard]] std::optional<Material> material_from_name(std::string_view name) noexcept;

/// Whether it is vegetation with leaves: all tiers, without grass and trunks.
[[nodiscard]] constexpr bool is_plant(Material material) noexcept {
    return material == Material::kLowVegetation || material == Material::kMediumVegetation ||
           material == Material::kHighVegetation;
}

/// Whether it covers a building and its slope shows.
[[nodiscard]] constexpr bool is_sloped_roof(Material material) noexcept {
    return material == Material::kRoof || material == Material::kOrangeRoof ||
           material == Material::kGreyRoof;
}

/// Whether it covers a building, sloped or flat.
[[nodiscard]] constexpr bool is_roof(Material material) noexcept {
    return is_sloped_roof(material) || material == Material::kFlatRoof;
}

/// Whether light passes through or between the parts of a voxel (water, leaves), so that voxels
/// behind it are visible.
[[nodiscard]] constexpr bool see_through(Material material) noexcept {
    return find_traits(material).optics != Optics::kOpaque;
}

/// sRGB, 8 bits per channel.
struct Rgb8 {
    std::uint8_t r = 0;
    std::uint8_t g = 0;
    std::uint8_t b = 0;
    friend bool operator==(const Rgb8&, const Rgb8&) = default;
};

/// @return nullopt unless it is "#rrggbb"
[[nodiscard]] std::optional<Rgb8> rgb8_from_hex(std::string_view text) noexcept;

/// Whether a field is allowed for a material in config/materials.toml. The palette needs only
/// colour and variation; the other fields are the ray tracer's, which validates them.
[[nodiscard]] bool is_appearance_field(std::string_view name) noexcept;
[[nodiscard]] std::string appearance_fields();  ///< their names, for messages

/// The colour of each material, and its variation.
struct Palette {
    struct Entry {
        Rgb8 colour;
        float variation = 0;  ///< relative spread of brightness between voxels, [0, 1]
    };
    std::array<Entry, kMaterialCount> entries;
    [[nodiscard]] const Entry& of(Material m) const noexcept { return entries[material_index(m)]; }
};

/// Reads the colours and variations of config/materials.toml.
/// @throws UsageError naming file, field, value and allowed range
[[nodiscard]] Palette load_palette(const std::filesystem::path& file);

}  // namespace terravox::voxel
