#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "voxelserver/serve/gkot/gkot_origin.hpp"

namespace terravox::gkot {

/// A block of voxels in the world's absolute grid of level 0; it may lie anywhere, also far outside
/// of the world.
struct Region {
    std::int64_t x = 0, y = 0, z = 0;     ///< its lowest, north-western voxel
    std::int32_t sx = 0, sy = 0, sz = 0;  ///< in [1, kMaxSide]; their product at most kMaxVoxels
};

/// The location of the requested box. One block is one voxel: a metre in the first system,
/// `voxel_m` here.
/// @param fetch used when the request has no tmz
/// @throws what `fetch` throws
[[nodiscard]] Region region_of(const voxel::WorldInfo& info, const BoxRequest& request,
                               const FetchBox& fetch);

/// The blocks of a region as block words, index x + z * sx + y * sx * sz (local coordinates); 0 for
/// air. A block of the world has the same word in every region that contains it. Boxes that do not
/// intersect `bounds` are not requested.
/// @throws what `fetch` throws; std::bad_alloc
[[nodiscard]] std::vector<std::uint32_t> blocks_of(const voxel::VoxelBounds& bounds,
                                                   const Region& region, const FetchBox& fetch);

/// Encodes the reply to /gkot/box?format=raw, big-endian 32-bit words: x, y, z of the request,
/// maxHeight, the number of blocks, the blocks, the number of columns (sx * sz), and for each
/// (index x + z * sx) the local y of its topmost block.
///
/// Where the first system's description is silent: a column without a block has -1 (0 would be a
/// block at the bottom); maxHeight is the largest of these tops, and -2 where there is no block at
/// all. Such an empty reply has the same length as any other of its size, all air and tops of -1,
/// so that a client that does not check for -2 still reads air.
[[nodiscard]] std::string encode_reply(const BoxRequest& request,
                                       const std::vector<std::uint32_t>& blocks);

/// Calls region_of, blocks_of and encode_reply. Peak memory is about 130 MiB.
[[nodiscard]] std::string box_reply(const voxel::WorldInfo& info, const BoxRequest& request,
                                    const FetchBox& fetch);

inline constexpr std::int64_t kNoTop = INT64_MIN;
/// Highest solid voxel (absolute y) for each of the 64 x 64 columns of one box column, index z * 64
/// + x; kNoTop for an empty column.
/// @param x, z any voxel of the box column
/// @throws what `fetch` throws
[[nodiscard]] std::vector<std::int64_t> column_tops(const voxel::VoxelBounds& bounds,
                                                    std::int64_t x, std::int64_t z,
                                                    const FetchBox& fetch);

}  // namespace terravox::gkot
