#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "voxelserver/gkot/gkot_origin.hpp"

namespace terravox::gkot {

/// A block of voxels in the world's absolute grid of level 0; may lie anywhere, also far outside
/// every world.
struct Region {
    std::int64_t x = 0, y = 0, z = 0;     ///< its lowest, north-western voxel
    std::int32_t sx = 0, sy = 0, sz = 0;  ///< in [1, kMaxSide], together at most kMaxVoxels
};

/// Where the requested box lies. One block is one voxel: a metre in the first system, `voxel_m`
/// here.
/// @param fetch used where the request leaves tmz out @throws what `fetch` throws
[[nodiscard]] Region region_of(const voxel::WorldInfo& info, const BoxRequest& request,
                               const FetchBox& fetch);

/// The blocks of a region as block words, index x + z * sx + y * sx * sz (local coordinates); 0
/// where nothing is. The same block of the world has the same word whatever region it is asked in.
/// Boxes that do not meet `bounds` are not asked for.
/// @throws what `fetch` throws; std::bad_alloc
[[nodiscard]] std::vector<std::uint32_t> blocks_of(const voxel::VoxelBounds& bounds,
                                                   const Region& region, const FetchBox& fetch);

/// The reply to /gkot/box?format=raw, words of 32 bits, big-endian: x, y, z as asked, maxHeight,
/// the number of blocks, the blocks, the number of columns (sx * sz), and for each (index x + z *
/// sx) the local y of its topmost block.
///
/// Where the first system's description is silent: a column without a block has -1 (0 would be a
/// block at the bottom); maxHeight is the largest of these tops, and -2 where there is no block at
/// all. Such an empty reply is as long as every other of its size, all air and tops of -1, so that
/// a client that does not look for -2 still reads air.
[[nodiscard]] std::string encode_reply(const BoxRequest& request,
                                       const std::vector<std::uint32_t>& blocks);

/// region_of, blocks_of and encode_reply. At most about 130 MiB are in use at a time.
[[nodiscard]] std::string box_reply(const voxel::WorldInfo& info, const BoxRequest& request,
                                    const FetchBox& fetch);

inline constexpr std::int64_t kNoTop = INT64_MIN;
/// Highest solid voxel (absolute y) of 64 x 64 columns of one box column, index z * 64 + x; kNoTop
/// where nothing is.
/// @param x, z any voxel of the box column @throws what `fetch` throws
[[nodiscard]] std::vector<std::int64_t> column_tops(const voxel::VoxelBounds& bounds,
                                                    std::int64_t x, std::int64_t z,
                                                    const FetchBox& fetch);

}  // namespace terravox::gkot
