#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "voxelserver/make/worlds/kind/damage_log.hpp"
#include "voxelserver/make/worlds/minecraft/block_appearance_cache.hpp"
#include "voxelserver/make/worlds/minecraft/chunk_store.hpp"
#include "voxelserver/make/worlds/minecraft/place_names.hpp"
#include "voxelserver/make/worlds/minecraft/voxel_chunk.hpp"

namespace terravox::minecraft {

/// What one thread needs to turn chunks into voxels.
struct ChunkTools {
    ChunkReader reader;
    VoxelMaker maker;
    std::vector<voxel::VoxelAttr> appearances{};  ///< those of one palette
    ChunkTools(const ChunkStore& store, BlockAppearanceCache& block_appearances)
        : reader(store), maker(block_appearances) {}
};

/// Chunks with min <= x < max, the same for z.
struct ChunkArea {
    ChunkPlace min;
    ChunkPlace max;
    friend bool operator==(const ChunkArea&, const ChunkArea&) = default;
};

/// The part worth framing of chunks that lie scattered, as where players walked off through a
/// portal: the largest part that is connected, over gaps of up to a hundred voxels. Of several
/// equally large ones, the north-western.
/// @return nullopt when all are connected, or there are none
[[nodiscard]] std::optional<ChunkArea> main_part(std::span<const ChunkPlace> places);

/// The result of a scan of a dimension's chunks.
struct ChunkSurvey {
    /// Chunks that hold anything; all existing ones when the scan was not complete.
    std::vector<ChunkPlace> places;
    std::int32_t min_y = 0, max_y = 0;  ///< heights of what they hold, half-open; equal: nothing
    std::size_t readable = 0;           ///< of those scanned
    bool complete = false;              ///< every chunk was scanned: places and heights are exact
};

/// Scans the chunks, or, where there are more than `most`, as many spread evenly over them: then
/// the heights are those of all the sections that these have, and of the game's own worlds. Damage
/// is added to `damage`.
/// @param threads 0 = one for each core
[[nodiscard]] ChunkSurvey survey_chunks(const ChunkStore& store,
                                        BlockAppearanceCache& block_appearances,
                                        worlds::DamageLog& damage, int threads, std::size_t most);

}  // namespace terravox::minecraft
