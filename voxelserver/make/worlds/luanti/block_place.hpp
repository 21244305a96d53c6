#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <string>

namespace terravox::luanti {

inline constexpr std::int32_t kBlockVoxels = 16;  ///< edge of a map block
/// Blocks lie in [-kFarthestBlock, kFarthestBlock) on each axis: the key of the older files cannot
/// encode others, and the game's world ends before.
inline constexpr std::int32_t kFarthestBlock = 2048;

/// The place of a map block, in voxel axes: it covers voxels [16 x, 16 x + 16) and so on; z counts
/// southwards, while the game's own z counts northwards.
struct BlockPlace {
    std::int32_t x = 0;
    std::int32_t y = 0;
    std::int32_t z = 0;
    friend auto operator<=>(const BlockPlace&, const BlockPlace&) = default;
};
struct BlockPlaceHash {
    [[nodiscard]] std::size_t operator()(const BlockPlace& p) const noexcept {
        const auto bits = [](std::int32_t v) {
            return static_cast<std::size_t>(static_cast<std::uint32_t>(v + kFarthestBlock));
        };
        return (bits(p.x) | bits(p.y) << 16 | bits(p.z) << 32) * 0x9E3779B97F4A7C15ULL;
    }
};

/// Converts a z of the game to ours, and back: of blocks as well as of nodes. The game's axes are
/// left-handed (x east, y up, z north), ours right-handed (z south), and node z of the game covers
/// [z, z + 1) there and [-1 - z, -z) here.
[[nodiscard]] constexpr std::int32_t mirrored(std::int32_t z) noexcept {
    return -1 - z;
}

[[nodiscard]] constexpr bool within_world(std::int64_t x, std::int64_t y, std::int64_t z) noexcept {
    const auto fits = [](std::int64_t v) { return v >= -kFarthestBlock && v < kFarthestBlock; };
    return fits(x) && fits(y) && fits(z);
}

/// For messages, in the game's coordinates: "map block (1, -2, 3)".
[[nodiscard]] inline std::string name_of(const BlockPlace& p) {
    return "map block (" + std::to_string(p.x) + ", " + std::to_string(p.y) + ", " +
           std::to_string(mirrored(p.z)) + ")";
}

}  // namespace terravox::luanti
