#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "common/voxel/box.hpp"
#include "voxelserver/make/worlds/minecraft/blocks/block_table.hpp"

namespace terravox::exports::anvil {

/// A block as it is written: its name and properties.
struct ExportBlock {
    std::string name;  ///< with "minecraft:"
    std::vector<std::pair<std::string, std::string>> properties;
    voxel::Material material = voxel::Material::kAir;
    voxel::Rgb8 colour;
};

using BlockId = std::uint16_t;  ///< index into ExportBlocks::all(); 0 = air

/// Which block each voxel becomes (config/blocks/export.toml). A block's name always means one
/// material. Safe to share between threads.
class ExportBlocks {
public:
    /// @param folder holds export.toml
    /// @param colours source of the colours of blocks
    /// @throws UsageError naming file, entry, value and allowed values: also for a material without
    /// a block, and for a block of two materials
    [[nodiscard]] static ExportBlocks load(const std::filesystem::path& folder,
                                           const minecraft::BlockTable& colours);

    [[nodiscard]] const std::vector<ExportBlock>& all() const noexcept { return m_all; }
    [[nodiscard]] BlockId plain(voxel::Material material) const noexcept {
        return m_choices[index(material)].plain;
    }
    /// The block of the material above soil and grass, where the game lets plants stand.
    [[nodiscard]] BlockId rooted(voxel::Material material) const noexcept {
        return m_choices[index(material)].rooted;
    }
    /// The block nearest in colour, of those of the material.
    [[nodiscard]] BlockId painted(voxel::Material material, voxel::Rgb8 colour) const noexcept;
    /// The material of each block, by name, for the side-car.
    [[nodiscard]] std::map<std::string, voxel::Material> meanings() const;

private:
    friend class ExportBlocksReader;
    struct Choice {
        BlockId plain = 0, rooted = 0;  ///< rooted: same as plain when not specified
        std::vector<BlockId> paint;
    };
    static std::size_t index(voxel::Material material) noexcept {
        return voxel::material_index(material);
    }
    std::vector<ExportBlock> m_all{ExportBlock{"minecraft:air", {}, voxel::Material::kAir, {}}};
    std::array<Choice, voxel::kMaterialCount> m_choices;
};

/// Approximate perceptual distance of two colours; whole numbers, so the same on every machine.
[[nodiscard]] std::int32_t colour_distance(voxel::Rgb8 a, voxel::Rgb8 b) noexcept;

}  // namespace terravox::exports::anvil
