#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "voxelserver/make/worlds/kind/damage_log.hpp"
#include "voxelserver/make/worlds/minecraft/chunk.hpp"
#include "voxelserver/make/worlds/minecraft/inflate.hpp"
#include "voxelserver/make/worlds/minecraft/place_names.hpp"
#include "voxelserver/make/worlds/minecraft/source.hpp"
#include "voxelserver/make/worlds/minecraft/voxel_chunk.hpp"
#include "voxelserver/make/worlds/minecraft/world_folder.hpp"

namespace terravox::minecraft {

/// Where the 32 x 32 chunks of a region lie in its file: index x + 32 z; sectors of 4 KiB, first <<
/// 8 | count; 0 = no such chunk.
using RegionTable = std::array<std::uint32_t, 1024>;
inline constexpr std::size_t kSectorBytes = 4096;
/// The table, and a table of times that is ignored here.
inline constexpr std::size_t kRegionHeadBytes = 2 * kSectorBytes;

/// @param head the first kRegionHeadBytes of the file, or all of it when it is shorter
/// @throws Error for a file that is shorter than its head
[[nodiscard]] RegionTable read_region_table(std::span<const std::uint8_t> head);

/// A chunk as stored in its file.
struct PackedChunk {
    Compression compression = Compression::kNone;
    bool external = false;  ///< `bytes` is empty: they are in a file of their own, c.X.Z.mcc
    std::span<const std::uint8_t> bytes;
};

/// @param location of a RegionTable, not 0
/// @param buffer holds the returned bytes
/// @throws Error for a chunk that lies past the end, is longer than its sectors, or packed in an
/// unknown way
[[nodiscard]] PackedChunk read_packed(const ByteFile& region, std::uint32_t location,
                                      std::vector<std::uint8_t>& buffer);

/// A chunk that is listed in some file.
struct ChunkRef {
    ChunkPlace place;
    std::uint32_t file = 0;      ///< index in the dimension's files
    std::uint32_t location = 0;  ///< in a region's table
};

/// The chunks of one dimension: their places, and their unpacked bytes. Thread-safe; the world's
/// folder must outlive it.
class ChunkStore {
public:
    /// Reads the head of every region. One that cannot be read is a line of damage().
    /// @param threads that do so, 0 = one for each core
    ChunkStore(const WorldFolder& world, const DimensionFolder& dimension, int threads);

    /// Region by region, and within each as in its table.
    [[nodiscard]] std::span<const ChunkRef> chunks() const noexcept { return m_chunks; }
    [[nodiscard]] const ChunkRef* find(const ChunkPlace& place) const noexcept;

    /// The buffers that one thread needs to read chunks.
    struct Reader {
        Inflater inflater;
        std::vector<std::uint8_t> buffer;
    };
    struct Bytes {
        std::span<const std::uint8_t> nbt;  ///< valid until the reader is used again
        Compression compression = Compression::kNone;
    };
    /// @throws Error: why it cannot be read
    [[nodiscard]] Bytes read(const ChunkRef& chunk, Reader& reader) const;

    /// For messages: "region/r.0.-1.mca, chunk 3, -20".
    [[nodiscard]] std::string to_name(const ChunkRef& chunk) const;
    /// Damage of whole files.
    [[nodiscard]] const std::vector<std::string>& damage() const noexcept { return m_damage; }
    [[nodiscard]] const std::vector<std::string>& notes() const noexcept { return m_notes; }
    [[nodiscard]] FileKind find_kind(const ChunkRef& chunk) const noexcept {
        return m_files[chunk.file].kind;
    }
    [[nodiscard]] const std::vector<ChunkFile>& files() const noexcept { return m_files; }

private:
    struct Indexed {
        std::vector<ChunkRef> chunks;
        std::string damage;
        std::string note;
    };
    [[nodiscard]] Indexed index_file(std::uint32_t file);
    void place_region(std::uint32_t file, std::vector<ChunkRef>& chunks);
    [[nodiscard]] Bytes read_external(const ChunkRef& chunk, Compression compression,
                                      Reader& reader) const;
    [[nodiscard]] const std::string& find_path(std::uint32_t file) const noexcept {
        return m_source.entries()[m_files[file].entry].path;
    }

    FileSource& m_source;
    std::vector<ChunkFile> m_files;
    std::vector<ChunkRef> m_chunks;
    std::vector<std::string> m_damage;
    std::vector<std::string> m_notes;
};

/// Reads chunks of one store, one after the other, and checks that each is at its own place. Not
/// thread-safe: one for each thread.
class ChunkReader {
public:
    explicit ChunkReader(const ChunkStore& store) : m_store(store) {}
    /// @param damage receives what is odd of the chunk
    /// @return valid until the next call
    /// @throws Error: why the chunk cannot be used
    const ChunkBlocks& read(const ChunkRef& chunk, worlds::DamageLog& damage);
    /// Compression of the chunk that was read last.
    [[nodiscard]] Compression compression() const noexcept { return m_compression; }

private:
    const ChunkStore& m_store;
    ChunkStore::Reader m_reader;
    ChunkBlocks m_blocks;
    Compression m_compression = Compression::kNone;
};

}  // namespace terravox::minecraft
