#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace terravox::pmtiles {

/// Tiles that follow each other and have the same bytes.
struct DirectoryEntry {
    std::uint64_t id = 0;      ///< of the first tile
    std::uint64_t offset = 0;  ///< of its bytes, from the first tile's
    std::uint32_t bytes = 0;   ///< at least 1
    std::uint32_t tiles = 1;   ///< 0: the bytes are a directory of the tiles from `id` on
};

/// Where tiles are: a root, and the leaves that it points to where it would be too long without.
struct DirectoryTree {
    std::string root;    ///< gzip, at most kMaxRoot_bytes
    std::string leaves;  ///< gzip each, one after another; empty: the root has all entries
    /// A reader's first request gets header and root: 16 KiB, as the specification asks.
    static constexpr std::size_t kMaxRoot_bytes = 16'384 - 127;
};

/// @param entries by ascending `id`
[[nodiscard]] DirectoryTree directory_tree(std::span<const DirectoryEntry> entries);

}  // namespace terravox::pmtiles
