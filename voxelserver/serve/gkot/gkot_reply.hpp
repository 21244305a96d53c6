#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/voxel/material.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/serve/gkot/gkot_request.hpp"

namespace terravox::gkot {

/// The numeric Minecraft block for a material: 0x00000DBB, BB = block id, D = data nibble; 0 for
/// air.
///
/// The mapping of the first system is kept: ground is dirt, low vegetation grass, medium vegetation
/// spruce leaves, high vegetation oak leaves, buildings and concrete light grey wool, roofs orange,
/// light grey or white wool, asphalt stone, water still water. Materials that it did not have are
/// mapped to the most similar block that can be distinguished.
[[nodiscard]] std::uint32_t block_word(voxel::Material material) noexcept;

/// Returns boxes of level 0 within the world's bounds; nullptr: air. Never called concurrently.
/// @throws Error when a box cannot be made
using FetchBox = std::function<std::shared_ptr<const voxel::Box>(const voxel::BoxKey& key)>;

/// The content of /gkot/origin.json. Heights in metres: the lower faces of voxels.
struct Origin {
    double tmx = 0, tmy = 0;  ///< as requested
    double tmz = -1;          ///< the automatic height of y = 0; -1 in a world without any voxel
    /// Lowest and highest column top around the origin, and their difference.
    double zmin = -1;
    double zmax = -1;
    double zrange = 0;
};

/// Determines the automatic height: that of the lowest of the 64 x 64 column tops (ground, water or
/// anything on them) of the origin's box column; where that is empty, the world's lowest voxel, and
/// zmin to zmax is then the whole world. A box requested without tmz is counted from the same
/// height: passing this tmz gives the same box as omitting it.
/// @throws what `fetch` throws
[[nodiscard]] Origin find_origin(const voxel::WorldInfo& info, const OriginRequest& request,
                                 const FetchBox& fetch);

/// {"tmx":..,"tmy":..,"tmz":..,"zmin":..,"zmax":..,"zrange":..}; integers without decimals, other
/// numbers with as many as a round trip requires.
[[nodiscard]] std::string to_json(const Origin& origin);

/// The voxel that contains a point, each coordinate by floor: x = floor(E / u), z = floor(-N / u),
/// y = floor(H / voxel_m).
/// @param value finite
/// @param unit above 0
/// @return clamped to +-2^53
[[nodiscard]] std::int64_t find_voxel(double value, double unit) noexcept;

/// The smallest height that find_voxel() maps to y, so that a reported height leads back to its
/// voxel in spite of rounding.
[[nodiscard]] double find_height(std::int64_t y, double voxel_m) noexcept;

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
[[nodiscard]] Region find_region(const voxel::WorldInfo& info, const BoxRequest& request,
                                 const FetchBox& fetch);

/// The blocks of a region as block words, index x + z * sx + y * sx * sz (local coordinates); 0 for
/// air. A block of the world has the same word in every region that contains it. Boxes that do not
/// intersect `bounds` are not requested.
/// @throws what `fetch` throws; std::bad_alloc
[[nodiscard]] std::vector<std::uint32_t> read_blocks(const voxel::VoxelBounds& bounds,
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

/// Calls find_region, read_blocks and encode_reply. Peak memory is about 130 MiB.
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
