#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace terravox::voxel {

/// What a voxel is, after classification. The numbers are part of the box format (docs/formats.md):
/// never renumber.
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
    kUnknown = 23,  ///< a class that no table names: kept visible
    kTrunk = 24,    ///< of a tree, from the ground to its crown
    kGlass = 25,
    kIce = 26,
    kLava = 27,     ///< gives light
    kLamp = 28,     ///< gives light, in its voxel's own colour
    kWood = 29,     ///< planks
    kMasonry = 30,  ///< stones or bricks, laid
    kPlain = 31,    ///< of one colour, without a drawing: cloth, plaster, cast and polished things
};
inline constexpr int kMaterialCount = 32;

[[nodiscard]] std::string_view material_name(Material material) noexcept;
[[nodiscard]] std::optional<Material> material_from_name(std::string_view name) noexcept;

/// Light and leaves pass: a voxel behind such a voxel can be seen.
[[nodiscard]] constexpr bool see_through(Material material) noexcept {
    return material == Material::kAir || material == Material::kWater ||
           material == Material::kLowVegetation || material == Material::kMediumVegetation ||
           material == Material::kHighVegetation || material == Material::kWire ||
           material == Material::kGlass || material == Material::kIce;
}

/// sRGB, 8 bits a channel.
struct Rgb8 {
    std::uint8_t r = 0, g = 0, b = 0;
    friend bool operator==(const Rgb8&, const Rgb8&) = default;
};

/// @return nullopt unless it is "#rrggbb"
[[nodiscard]] std::optional<Rgb8> rgb8_from_hex(std::string_view text) noexcept;

/// What config/materials.toml may say of a material. The palette needs only colour and variation;
/// the rest is the ray tracer's, which checks it.
[[nodiscard]] bool is_look_field(std::string_view name) noexcept;
[[nodiscard]] std::string look_fields();  ///< their names, for messages

/// The look of each material.
struct Palette {
    struct Entry {
        Rgb8 colour;
        float variation = 0;  ///< relative spread of brightness between voxels, [0, 1]
    };
    std::array<Entry, kMaterialCount> entries;
    [[nodiscard]] const Entry& of(Material m) const noexcept {
        return entries[static_cast<std::size_t>(m) % kMaterialCount];
    }
};

/// Reads colours and variations of config/materials.toml. @throws UsageError naming file, field,
/// value and allowed range
[[nodiscard]] Palette load_palette(const std::filesystem::path& file);

}  // namespace terravox::voxel
