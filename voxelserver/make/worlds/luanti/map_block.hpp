#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

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
[[nodiscard]] inline std::string to_name(const BlockPlace& p) {
    return "map block (" + std::to_string(p.x) + ", " + std::to_string(p.y) + ", " +
           std::to_string(mirrored(p.z)) + ")";
}

/// Decompresses the contents of map blocks, one after the other, into a buffer that is reused. Not
/// thread-safe: one for each thread.
class Unpacker {
public:
    /// Maximum size that one stream may decompress to. Its nodes take 16 KiB; the rest is the
    /// contents of chests, signs and books.
    static constexpr std::size_t kLimitBytes = std::size_t{16} << 20;

    Unpacker();
    ~Unpacker();
    Unpacker(const Unpacker&) = delete;
    Unpacker& operator=(const Unpacker&) = delete;

    struct Stream {
        std::span<const std::uint8_t> bytes;  ///< valid until the next call
        std::size_t packed_bytes = 0;         ///< how long the stream is; others may follow
    };
    /// The zlib stream with which `packed` begins.
    /// @throws Error
    [[nodiscard]] Stream zlib(std::span<const std::uint8_t> packed);
    /// The zstd frame with which `packed` begins.
    /// @return as Stream::bytes
    /// @throws Error
    [[nodiscard]] std::span<const std::uint8_t> zstd(std::span<const std::uint8_t> packed);

private:
    struct Contexts;
    std::unique_ptr<Contexts> m_contexts;
    std::vector<std::uint8_t> m_buffer;
};

inline constexpr std::size_t kBlockNodes = 16 * 16 * 16;
/// Versions of the serialization that are read: those of the game since 0.4.0 that name their nodes
/// in each block.
inline constexpr int kOldestVersion = 25;
inline constexpr int kNewestVersion = 29;

/// A map block as it is stored, in the game's axes.
struct MapBlock {
    static constexpr std::size_t kMaxNameBytes = 256;

    struct Name {
        std::uint16_t id = 0;
        std::string_view name;  ///< "default:stone"; any bytes
    };
    int version = 0;
    std::array<std::uint16_t, kBlockNodes> ids{};  ///< of node (x, y, z): x + 16 y + 256 z
    std::vector<Name> names;                       ///< by rising id, each id once
};

/// Reads map blocks one after the other. Not thread-safe: one for each thread.
class MapBlockReader {
public:
    /// @param blob must live while the names are used
    /// @return valid until the next call
    /// @throws Error: why the block cannot be used; none of its nodes may then be used
    const MapBlock& read(std::span<const std::uint8_t> blob);

private:
    Unpacker m_unpacker;
    MapBlock m_block;
};

}  // namespace terravox::luanti
