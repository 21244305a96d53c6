#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "common/voxel/material.hpp"

namespace terravox::imagery {

/// Materials as a bit mask: bit m for material m.
using MaterialSet = std::uint64_t;
static_assert(voxel::kMaterialCount <= 64, "a MaterialSet has a bit for each material");

[[nodiscard]] constexpr MaterialSet to_bit(voxel::Material m) noexcept {
    return MaterialSet{1} << static_cast<unsigned>(m);
}

/// CIELAB with the D65 white point: `l` in [0, 100], `a` (green to red) and `b` (blue to yellow)
/// about -110 to 110.
struct Lab {
    double l = 0;
    double a = 0;
    double b = 0;
};

/// Cube root of x >= 1e-6, relative error below 1e-12; the same bits on every machine (see
/// common/util/det_math.hpp). Two steps of Halley's method from an initial estimate that divides
/// the exponent by three.
[[nodiscard]] constexpr double cube_root(double x) noexcept {
    constexpr std::uint64_t kThirdOfBias =
        std::uint64_t{0x2A9F7893}
        << 32;  // two thirds of the exponent's bias, adjusted to balance the estimate's error
    double y = std::bit_cast<double>(std::bit_cast<std::uint64_t>(x) / 3 + kThirdOfBias);
    for (int i = 0; i < 2; ++i) {
        const double cube = y * y * y;
        y = y * (cube + 2 * x) / (2 * cube + x);
    }
    return y;
}

/// Converts sRGB to CIELAB. Ref: IEC 61966-2-1 (sRGB) and CIE 15 (colorimetry), with the white
/// point that results from sRGB's own primaries.
[[nodiscard]] Lab to_lab(voxel::Rgb8 colour) noexcept;

}  // namespace terravox::imagery

namespace terravox::voxel {
class ByteWriter;
}

namespace terravox::imagery {

/// The kind of surface of a column by the LiDAR data: it limits the materials that a colour may
/// select.
enum class Group : std::uint8_t {
    /// Empty, or a thing whose material is not refined by colour (bridge, object).
    kNone,
    kGround,  ///< Ground, where the survey has no class for water: dark blue ground becomes water.
    kDryGround,  ///< ground, where the survey has a class for water
    kBuilding,
    kVegetation,
    kWater,
};
inline constexpr int kGroupCount = 6;

inline constexpr float kNoNdvi = std::numeric_limits<float>::quiet_NaN();

/// Normalized difference vegetation index, [-1, 1]; 0 where both values are 0.
/// Ref: Rouse, Haas, Schell & Deering, "Monitoring Vegetation Systems in the Great Plains with
/// ERTS", 1974.
[[nodiscard]] constexpr float ndvi(std::uint8_t nir, std::uint8_t red) noexcept {
    const int sum = nir + red;
    return sum == 0 ? 0.0F : static_cast<float>(nir - red) / static_cast<float>(sum);
}

/// Maps a colour seen from above to a material: that of the nearest entry of a colour table.
/// Immutable, thread-safe.
class ColourMap {
public:
    /// Reads config/palettes/<id>.toml, following `extends`. A path to a .toml file works too.
    /// @throws UsageError for an unknown id; Error for a bad file, naming field, value and allowed
    /// range
    static ColourMap load(const std::string& id_or_path);

    /// The material of the nearest entry (to 1/64 of a unit of CIELAB; a tie is won by the first in
    /// the file) among the group's candidates that the NDVI rules allow. kAir where the group has
    /// no candidates: the column keeps its material.
    [[nodiscard]] voxel::Material nearest(voxel::Rgb8 colour, Group group,
                                          float ndvi = kNoNdvi) const noexcept;

    /// For columns without a colour: the material, where the NDVI rules leave a single candidate,
    /// else kAir.
    [[nodiscard]] voxel::Material by_ndvi(Group group, float ndvi) const noexcept;

    /// Adds all values that results depend on, for a fingerprint; not notes, names or the order of
    /// a file's sections.
    void add_values(voxel::ByteWriter& out) const;

    [[nodiscard]] std::size_t entry_count() const noexcept { return m_entry_count; }
    /// Bit m is set when material m is a candidate of the group.
    [[nodiscard]] MaterialSet candidates(Group group) const noexcept {
        return m_candidates[static_cast<std::size_t>(group)];
    }

private:
    struct Entry {
        voxel::Material material{};
        voxel::Rgb8 colour;
    };
    /// A range of the vegetation index and the materials that it allows. The first matching rule
    /// applies.
    struct NdviRule {
        float above = -2;
        float below = 2;
        double darker_than = 1000;  ///< upper limit of the lightness, L*
        MaterialSet only = ~MaterialSet{0};
    };
    /// A position in the colour space in whole steps of 1/64 (CIELAB) or 1/16 (RGB) of a unit, so
    /// that squared distances are exact, fit in 32 bits, and can be compared four at a time.
    struct Place {
        std::int32_t x = 0;
        std::int32_t y = 0;
        std::int32_t z = 0;
    };
    /// The entries of one set of candidates, as a structure of arrays, padded to a multiple of four
    /// with the first entry.
    struct Set {
        std::vector<std::int32_t> x;
        std::vector<std::int32_t> y;
        std::vector<std::int32_t> z;
        std::vector<voxel::Material> material;
        MaterialSet materials = 0;
    };
    friend class ColourMapLoader;
    [[nodiscard]] Place find_place(voxel::Rgb8 colour, double& lightness) const noexcept;
    [[nodiscard]] const Set& set_for(Group group, float ndvi, double lightness) const noexcept;
    void build_sets(const std::vector<Entry>& entries);

    bool m_cielab = true;
    double m_lightness_weight = 1;
    std::size_t m_entry_count = 0;
    std::array<MaterialSet, kGroupCount> m_candidates{};
    std::vector<NdviRule> m_rules;
    std::vector<std::array<Set, kGroupCount>> m_sets;  ///< [0] = no rule applies, [i + 1] = rule i
};

}  // namespace terravox::imagery
