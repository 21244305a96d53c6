#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "common/voxel/world.hpp"
#include "voxelserver/make/worlds/kind/damage_log.hpp"
#include "voxelserver/make/worlds/luanti/map_block.hpp"
#include "voxelserver/make/worlds/luanti/map_database.hpp"
#include "voxelserver/make/worlds/luanti/node_block.hpp"

namespace terravox::luanti {

/// Which columns of boxes hold blocks, and between which heights. Of constant size (about 6 MiB),
/// whatever a file claims to hold. Reading is thread-safe once it is complete.
class BlockIndex {
public:
    /// Heights in map blocks, half-open; equal: nothing.
    struct Heights {
        std::int16_t begin = 0;
        std::int16_t end = 0;
    };

    BlockIndex();
    void add(const BlockPlace& place) noexcept;

    /// Bounds of all blocks, in voxels, half-open; aligned to whole blocks.
    [[nodiscard]] voxel::VoxelBounds bounds() const noexcept;
    /// Heights of the blocks in a column of boxes of level 0.
    /// @param bx, bz any
    [[nodiscard]] Heights heights(std::int32_t bx, std::int32_t bz) const noexcept;
    /// Whether a column of boxes of a level holds any block.
    /// @param level in [0, kMaxLevel)
    [[nodiscard]] bool holds(int level, std::int32_t bx, std::int32_t bz) const noexcept;

private:
    /// Columns of boxes lie in [-kFarthestColumn, kFarthestColumn) at level 0.
    static constexpr std::int32_t kFarthestColumn =
        kFarthestBlock * kBlockVoxels / voxel::kBoxSizeX;
    /// From this level on there are 2 x 2 columns, one on each side of the origin.
    static constexpr int kTopLevel = 9;
    static_assert(kFarthestColumn >> kTopLevel == 1);

    [[nodiscard]] static std::size_t compute_index(int level, std::int32_t bx,
                                                   std::int32_t bz) noexcept;

    std::vector<Heights> m_heights;
    std::array<std::vector<bool>, kTopLevel + 1> m_holds;
    BlockPlace m_min;  ///< of all blocks
    BlockPlace m_max;  ///< of all blocks, inclusive; below m_min: there are none
};

/// The result of a scan of the blocks of a world.
struct BlockSurvey {
    BlockIndex index;           ///< of blocks that hold anything; of all when not complete
    voxel::VoxelBounds bounds;  ///< of what they hold, x and z to whole blocks
    voxel::VoxelBounds framed;  ///< of those scanned; empty when complete
    std::uint64_t blocks = 0;   ///< in the world, without those with an invalid key
    std::size_t looked_at = 0;  ///< of these, scanned
    std::size_t damaged = 0;    ///< of those scanned
    std::size_t empty = 0;      ///< of those scanned: nothing but air
    std::map<int, std::size_t> versions;  ///< of the serialization, of those that can be read
    [[nodiscard]] bool complete() const noexcept { return looked_at == blocks; }
};

/// Reads all keys, and decodes every block, or, where there are more than `most`, between half of
/// `most` and `most` blocks spread evenly over them. Damage is added to `damage`.
/// @param threads 0 = one for each core
/// @param most at least 1
/// @throws Error when the keys cannot be read
[[nodiscard]] BlockSurvey survey_blocks(MapDatabase& database, NodeAppearances& appearances,
                                        worlds::DamageLog& damage, int threads, std::size_t most);

}  // namespace terravox::luanti
