#pragma once

#include <cstdint>

#include "common/voxel/box.hpp"

/// The layout of a box archive, version 1 (docs/formats/box-archive.md). Little-endian; the
/// structures below are stored in the file byte for byte.
namespace terravox::voxel::archive {

inline constexpr char kMagic[8] = {'T', 'V', 'X', 'A', 'R', 'C', '\r', '\n'};
inline constexpr char kShardMagic[8] = {'T', 'V', 'X',  'S',
                                        'H', 'D', '\r', '\n'};  ///< archive_parts.hpp
inline constexpr char kChangeMagic[8] = {'T', 'V', 'X',  'C',
                                         'H', 'G', '\r', '\n'};  ///< archive_parts.hpp
inline constexpr std::uint32_t kVersion = 1;
inline constexpr const char* kEnding = ".tvx";

/// At offset 0.
struct Header {
    char magic[8];
    std::uint32_t version;
    /// Number of places where the data of the source world were damaged.
    std::uint32_t damage;
    std::uint64_t info_offset, info_bytes;  ///< JSON as returned by /v2/world
    std::uint64_t root_offset, root_bytes;  ///< 0 until the archive is finished
    std::uint64_t file_bytes;
    std::uint64_t checksum;  ///< XXH64 of the preceding bytes of the header
};
static_assert(sizeof(Header) == 64);

enum class Kind : std::uint32_t {
    kBox = 0,   ///< a box: a zstd frame
    kHole = 1,  ///< the box was unavailable when the archive was written: the reason, UTF-8
};

struct Key {
    std::int32_t level;
    std::int32_t bx;
    std::int32_t by;
    std::int32_t bz;
};

/// Precedes each frame.
struct Record {
    Key key;
    std::uint32_t bytes;
    Kind kind;
    std::uint64_t checksum;  ///< XXH64 of the frame
};
static_assert(sizeof(Record) == 32);

/// An entry of a leaf of the index.
struct Entry {
    Key key;
    std::uint64_t offset;  ///< of the frame
    std::uint32_t bytes;
    Kind kind;
};
static_assert(sizeof(Entry) == 32);

/// An entry of the root of the index. It refers to a leaf, which is a zstd frame of that leaf's
/// entries.
struct Leaf {
    Key first;
    std::uint64_t offset;
    std::uint32_t bytes;
    std::uint32_t entries;
    std::uint64_t checksum;  ///< XXH64 of the frame
};
static_assert(sizeof(Leaf) == 40);

inline constexpr std::uint32_t kLeafEntries = 1024;
/// A box in which every voxel has attributes is 9 MiB uncompressed.
inline constexpr std::uint32_t kMaxFrame_bytes = 16 << 20;

/// Records of one box of this level, and of all below it, are made and written together.
inline constexpr int kSubtreeLevel = 3;

[[nodiscard]] constexpr Key to_key(const BoxKey& k) noexcept {
    return {k.level, k.bx, k.by, k.bz};
}
[[nodiscard]] constexpr BoxKey to_key(const Key& k) noexcept {
    return {k.level, k.bx, k.by, k.bz};
}

/// Sort order of entries: by level, then along the Morton curve.
[[nodiscard]] inline bool before(const Key& a, const Key& b) noexcept {
    if (a.level != b.level)
        return a.level < b.level;
    return morton_encode(a.bx, a.by, a.bz) < morton_encode(b.bx, b.by, b.bz);
}
/// Whether the key lies in the range in which its Morton code is unique.
[[nodiscard]] constexpr bool in_range(const Key& k) noexcept {
    const auto fits = [](std::int32_t v) { return v >= -(1 << 20) && v < (1 << 20); };
    return k.level >= 0 && k.level <= kMaxLevel && fits(k.bx) && fits(k.by) && fits(k.bz);
}

}  // namespace terravox::voxel::archive
