#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <shared_mutex>
#include <span>
#include <string_view>
#include <vector>

#include "common/voxel/box.hpp"
#include "voxelserver/make/worlds/minecraft/blocks/block_table.hpp"

namespace terravox::minecraft {

/// A palette entry (bytes of NBT), parsed. `properties` point into those bytes.
/// @throws NbtError
struct PaletteName {
    std::string_view name;
    std::vector<Property> properties;
};
void palette_name(std::string_view entry, PaletteName& out);

/// The appearance of each block; the table is searched once for each distinct entry. Thread-safe.
/// Blocks that match no entry of the table are logged (UnknownNames).
class BlockAppearanceCache {
public:
    explicit BlockAppearanceCache(BlockTable table);

    /// The voxels that palette entries stand for.
    /// @param out as long as `entries`
    /// @throws NbtError for an invalid entry
    void of(std::span<const std::string_view> entries, std::span<voxel::VoxelAttr> out);
    /// @param number id * 16 + data
    [[nodiscard]] voxel::VoxelAttr of_number(std::uint16_t number);

private:
    [[nodiscard]] voxel::VoxelAttr find_appearance(std::string_view entry);

    const BlockTable m_table;
    std::shared_mutex m_mutex;  ///< guards m_appearances, by the bytes of a palette entry
    ByName<voxel::VoxelAttr> m_appearances;
    static constexpr std::size_t kNumbers = 65536;
    /// A VoxelAttr each; kUnset until it is first queried.
    std::unique_ptr<std::atomic<std::uint64_t>[]> m_numbers;
    UnknownNames m_unknown{"no table knows the block"};
};

}  // namespace terravox::minecraft
