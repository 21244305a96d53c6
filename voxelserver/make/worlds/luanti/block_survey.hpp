#pragma once

#include <cstddef>
#include <cstdint>
#include <map>

#include "common/voxel/world.hpp"
#include "voxelserver/make/worlds/kind/damage_log.hpp"
#include "voxelserver/make/worlds/luanti/block_index.hpp"
#include "voxelserver/make/worlds/luanti/map_database.hpp"
#include "voxelserver/make/worlds/luanti/node_appearances.hpp"

namespace terravox::luanti {

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
