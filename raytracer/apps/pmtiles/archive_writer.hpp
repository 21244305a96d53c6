#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "common/util/atomic_file.hpp"
#include "voxelserver/out/export/shape/byte_file.hpp"

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

/// What the tiles of an archive are, with the format's numbers.
enum class TileFormat : std::uint8_t { kPng = 2, kWebp = 4 };

/// Header fields and metadata of an archive.
struct ArchiveFacts {
    TileFormat format = TileFormat::kWebp;
    int min_zoom = 0;
    int max_zoom = 0;
    std::array<double, 4> bounds_deg{};  ///< west, south, east, north; WGS 84
    std::string metadata;                ///< a JSON object, UTF-8
};

/// Writes a PMTiles archive, version 3: tiles of a map in one file, which pages read by ranges from
/// any static host. Tiles with the same bytes are stored once. Memory: some 100 bytes a tile; the
/// tiles themselves are spooled next to the file. The file appears under its name when it is
/// complete. Not thread-safe. Ref: https://github.com/protomaps/PMTiles, spec/v3.
class ArchiveWriter {
public:
    /// @throws Error when the file cannot be written
    explicit ArchiveWriter(const std::filesystem::path& file);
    /// @param id above that of the tile before
    /// @param tile not empty, less than 4 GiB
    /// @throws Error
    void add(std::uint64_t id, std::string_view tile);
    /// Completes the file; no tile may be added afterwards.
    /// @throws Error, also without any tile
    void finish(const ArchiveFacts& facts);

private:
    struct Place {
        std::uint64_t offset;
        std::uint32_t bytes;
    };
    struct Hash {
        std::array<std::uint64_t, 2> bits;
        friend bool operator==(const Hash&, const Hash&) = default;
    };
    struct HashOfHash {
        std::size_t operator()(const Hash& hash) const noexcept { return hash.bits[0]; }
    };
    [[nodiscard]] Place store(std::string_view tile);

    std::string m_attempt;
    util::AtomicFile m_target;
    exports::ByteFile m_spool;
    std::vector<DirectoryEntry> m_entries;
    std::unordered_map<Hash, Place, HashOfHash> m_stored;  ///< by content
    std::uint64_t m_tiles = 0;
};

}  // namespace terravox::pmtiles
