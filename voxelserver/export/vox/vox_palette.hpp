#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <unordered_map>
#include <vector>

#include "common/voxel/box.hpp"
#include "voxelserver/export/vox/colour_counts.hpp"

namespace terravox::exports {

/// A colour of a MagicaVoxel file and what it stands for.
struct VoxColour {
    voxel::Rgb8 colour;
    voxel::Material material = voxel::Material::kAir;  ///< of all that are no special_in_vox(): air
};

/// Materials that MagicaVoxel has a way of showing of their own: it wants colours that nothing else
/// has.
[[nodiscard]] constexpr bool special_in_vox(voxel::Material m) noexcept {
    using enum voxel::Optics;
    const voxel::MaterialTraits& traits = voxel::traits_of(m);
    return traits.glow > 0 || traits.optics == kWater || traits.optics == kGlass ||
           traits.optics == kIce;
}

/// Chooses the 255 colours of a file: those of materials as they are, of each special material up
/// to sixteen of its voxels' own, and for all others the rest. Count first, then choose() once,
/// then ask. Depends on the counts alone.
class VoxPalette {
public:
    explicit VoxPalette(const voxel::Palette& looks) : m_looks(looks) {}
    /// @param own whether the colour is the voxel's own, else its material's
    void count(voxel::Material material, voxel::Rgb8 colour, bool own);
    /// @return colour i has the index i + 1 in the file; at most 255
    std::vector<VoxColour> choose();
    /// @return 1 to 255, for what was counted
    [[nodiscard]] std::uint8_t index_of(voxel::Material material, voxel::Rgb8 colour,
                                        bool own) const;

private:
    static constexpr std::size_t kMax = 255, kMaxOfSpecial = 16;
    struct Group {
        ColourCounts counts;
        std::unordered_map<std::uint32_t, std::uint8_t> index_of_cell;
    };
    /// Which colours are chosen together.
    [[nodiscard]] static voxel::Material group_of(voxel::Material m) noexcept {
        return special_in_vox(m) ? m : voxel::Material::kAir;
    }
    void take(Group& group, voxel::Material material, std::size_t most,
              std::vector<VoxColour>& out) const;
    const voxel::Palette& m_looks;
    std::array<bool, voxel::kMaterialCount>
        m_plain{};  ///< materials with voxels without a colour of their own
    std::array<std::uint8_t, voxel::kMaterialCount> m_index_of_plain{};
    std::map<voxel::Material, Group> m_groups;
};

}  // namespace terravox::exports
