#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <unordered_map>
#include <vector>

#include "common/voxel/box.hpp"
#include "common/voxel/material.hpp"

namespace terravox::exports {

/// Counts colours in bounded memory: exactly as long as there are few, then in ever larger cells of
/// similar colours. The result does not depend on the order of counting.
class ColourCounts {
public:
    static constexpr std::size_t kMaxCells = std::size_t{1} << 16;

    struct Cell {
        std::uint32_t key = 0;  ///< to_key() of its colours
        std::uint64_t count = 0;
        voxel::Rgb8 mean;
    };

    void add(voxel::Rgb8 colour);
    /// All cells, by rising key.
    [[nodiscard]] std::vector<Cell> cells() const;
    /// The current cell of a colour.
    [[nodiscard]] std::uint32_t to_key(voxel::Rgb8 c) const noexcept {
        return static_cast<std::uint32_t>(c.r >> m_shift) << 16 |
               static_cast<std::uint32_t>(c.g >> m_shift) << 8 |
               static_cast<std::uint32_t>(c.b >> m_shift);
    }
    [[nodiscard]] std::size_t size() const noexcept { return m_sums.size(); }

private:
    struct Sum {
        std::uint64_t count = 0;
        std::uint64_t r = 0;
        std::uint64_t g = 0;
        std::uint64_t b = 0;
    };
    void coarsen();
    int m_shift = 0;  ///< low bits of a channel that cells ignore
    std::unordered_map<std::uint32_t, Sum> m_sums;
};

/// A few colours that represent many.
struct FewColours {
    std::vector<voxel::Rgb8> colours;
    std::vector<std::uint8_t> of_cell;  ///< for each given cell, the index of its colour
};

/// The `max_colours` colours that differ least from those of the cells, perceptually (squared
/// distance in OKLab, summed over all counted colours): exactly theirs where there are no more than
/// that. Depends only on the arguments: the same on every machine.
///
/// Ref: Heckbert, "Color Image Quantization for Frame Buffer Display", SIGGRAPH 1982 (median cut),
/// here cut where the spread is largest; Lloyd, "Least Squares Quantization in PCM", 1982
/// (k-means); Ottosson, "A perceptual color space for image processing", 2020 (OKLab).
/// @param cells at least one
/// @param max_colours 1 to 255
[[nodiscard]] FewColours few_colours(std::span<const ColourCounts::Cell> cells,
                                     std::size_t max_colours);

/// A colour of a MagicaVoxel file and the material that it represents.
struct VoxColour {
    voxel::Rgb8 colour;
    voxel::Material material = voxel::Material::kAir;  ///< air for all but special_in_vox()
};

/// Whether MagicaVoxel displays a material specially: such a material needs colours of its own.
[[nodiscard]] constexpr bool special_in_vox(voxel::Material m) noexcept {
    using enum voxel::Optics;
    const voxel::MaterialTraits& traits = voxel::find_traits(m);
    return traits.glow > 0 || traits.optics == kWater || traits.optics == kGlass ||
           traits.optics == kIce;
}

/// Chooses the 255 colours of a file: those of materials as they are, for each special material up
/// to sixteen of its voxels' own, and for all others the rest. Call count() first, then choose()
/// once, then compute_index(). Depends on the counts alone.
class VoxPalette {
public:
    explicit VoxPalette(const voxel::Palette& palette) : m_palette(palette) {}
    /// @param own whether the colour is the voxel's own, else its material's
    void count(voxel::Material material, voxel::Rgb8 colour, bool own);
    /// @return colour i has the index i + 1 in the file; at most 255
    std::vector<VoxColour> choose();
    /// @return 1 to 255, for what was counted
    [[nodiscard]] std::uint8_t compute_index(voxel::Material material, voxel::Rgb8 colour,
                                             bool own) const;

private:
    static constexpr std::size_t kMax = 255;
    static constexpr std::size_t kMaxOfSpecial = 16;
    struct Group {
        ColourCounts counts;
        std::unordered_map<std::uint32_t, std::uint8_t> index_of_cell;
    };
    /// The group in which a material's colours are chosen.
    [[nodiscard]] static voxel::Material choose_group(voxel::Material m) noexcept {
        return special_in_vox(m) ? m : voxel::Material::kAir;
    }
    void take(Group& group, voxel::Material material, std::size_t max_colours,
              std::vector<VoxColour>& out) const;
    const voxel::Palette& m_palette;
    /// Materials with voxels without a colour of their own.
    std::array<bool, voxel::kMaterialCount> m_plain{};
    std::array<std::uint8_t, voxel::kMaterialCount> m_index_of_plain{};
    std::map<voxel::Material, Group> m_groups;
};

}  // namespace terravox::exports
