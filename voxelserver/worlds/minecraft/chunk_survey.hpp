#pragma once

#include <cstdint>
#include <vector>

#include "voxelserver/worlds/kind/damage_log.hpp"
#include "voxelserver/worlds/minecraft/block_appearance_cache.hpp"
#include "voxelserver/worlds/minecraft/chunk_store.hpp"

namespace terravox::minecraft {

/// What a look through a dimension's chunks found.
struct ChunkSurvey {
    std::vector<ChunkPlace>
        places;  ///< chunks that hold anything; all that are there when not every one was looked at
    std::int32_t min_y = 0, max_y = 0;  ///< heights of what they hold, half-open; equal: nothing
    std::size_t readable = 0;           ///< of those looked at
    bool complete = false;              ///< every chunk was looked at: places and heights are exact
};

/// Looks through the chunks, or, where there are more than `most`, through as many spread evenly
/// over them: then the heights are those of all the sections that these have, and of the game's own
/// worlds. What is damaged goes to `damage`. @param threads 0 = one for each core
[[nodiscard]] ChunkSurvey survey_chunks(const ChunkStore& store, BlockAppearanceCache& book,
                                        worlds::DamageLog& damage, int threads, std::size_t most);

}  // namespace terravox::minecraft
