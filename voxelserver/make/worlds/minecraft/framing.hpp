#pragma once

#include <optional>
#include <span>

#include "voxelserver/make/worlds/minecraft/chunk_place.hpp"

namespace terravox::minecraft {

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

}  // namespace terravox::minecraft
