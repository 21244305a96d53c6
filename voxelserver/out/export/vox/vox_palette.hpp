#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <unordered_map>
#include <vector>

#include "common/voxel/box.hpp"
#include "voxelserver/out/export/vox/colour_counts.hpp"

namespace terravox::exports {

/// A colour of a MagicaVoxel file and the material that it represents.
struct VoxColour {
    voxel::Rgb8 colour;
    voxel::Material material = voxel::Material::kAir;  ///< air for all but special_in_vox()
};

/// Whether MagicaVoxel displays a material specially: such a material needs colours of its own.
[[nodiscard]] constexpr bool special_in_vox(voxel::Material m) noexcept {
    using enum voxel::Optics;
    const voxel::MaterialTraits& traits = voxel::traits_of(m);
    return traits.glow > 0 || traits.optics == kWater || traits.optics == kGlass ||
           traits.optics == kIce;
}

/// Chooses the 255 colours of a file: those of materials as they are, for each special material up
/// to sixteen of its voxels' own, and for all others the rest. Call count() first, then choose()
/// once, then index_of(). Depends on the counts alone.
class VoxPalette {
public:
    explicit VoxPalette(const voxel::Palette& palette) : m_palette(palette) {}
    /// @param own whether the colour is the voxel's own, else its material's
    void count(voxel::Material material, voxel::Rgb8 colour, bool own);
    /// @return colour i has the index i + 1 in the file; at most 255
    std::vector<VoxColour> choose();
    /// @return 1 to 255, for what was counted
    [[nodiscard]] std::uint8_t index_of(voxel::Material material, voxel::Rgb8 colour,
                                        bool own) const;

private:
    static constexpr std::size_t kMax = 255;
    static constexpr std::size_t kMaxOfSpecial = 16;
    struct Group {
        ColourCounts counts;
        std::unordered_map<std::uint32_t, std::uint8_t> index_of_cell;
    };
    /// The group in which a material's colours are chosen.
    [[nodiscard]] static voxel::Material group_of(voxel::Material m) noexcept {
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
