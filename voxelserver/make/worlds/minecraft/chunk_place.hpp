#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>

#include "voxelserver/make/worlds/minecraft/place_names.hpp"

namespace terravox::minecraft {

/// Place of a chunk: 16 x 16 columns of voxels.
struct ChunkPlace {
    std::int32_t x = 0;
    std::int32_t z = 0;
    friend auto operator<=>(const ChunkPlace&, const ChunkPlace&) = default;
};
struct ChunkPlaceHash {
    [[nodiscard]] std::size_t operator()(const ChunkPlace& p) const noexcept {
        return (static_cast<std::size_t>(static_cast<std::uint32_t>(p.x)) << 32 |
                static_cast<std::uint32_t>(p.z)) *
               0x9E3779B97F4A7C15ULL;
    }
};

/// Whether a chunk may lie at this place.
[[nodiscard]] constexpr bool within_world(const ChunkPlace& p) noexcept {
    return p.x >= -kFarthestChunk && p.x < kFarthestChunk && p.z >= -kFarthestChunk &&
           p.z < kFarthestChunk;
}

}  // namespace terravox::minecraft
