#pragma once

#include <cstdint>
#include <vector>

#include "voxelserver/make/worlds/kind/damage_log.hpp"
#include "voxelserver/make/worlds/minecraft/block_appearance_cache.hpp"
#include "voxelserver/make/worlds/minecraft/chunk_store.hpp"

namespace terravox::minecraft {

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
