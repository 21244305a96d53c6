#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "voxelserver/make/worlds/minecraft/chunk_place.hpp"
#include "voxelserver/make/worlds/minecraft/inflate.hpp"
#include "voxelserver/make/worlds/minecraft/world_folder.hpp"

namespace terravox::minecraft {

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
    [[nodiscard]] bool knows_place(const ChunkRef& chunk) const noexcept {
        return m_files[chunk.file].kind != FileKind::kChunk;
    }

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
    [[nodiscard]] std::string name_of(const ChunkRef& chunk) const;
    /// Damage of whole files.
    [[nodiscard]] const std::vector<std::string>& damage() const noexcept { return m_damage; }
    [[nodiscard]] const std::vector<std::string>& notes() const noexcept { return m_notes; }
    [[nodiscard]] FileKind kind_of(const ChunkRef& chunk) const noexcept {
        return m_files[chunk.file].kind;
    }
    [[nodiscard]] const std::vector<ChunkFile>& files() const noexcept { return m_files; }

private:
    struct Indexed {
        std::vector<ChunkRef> chunks;
        std::string damage;
    };
    [[nodiscard]] Indexed index_file(std::uint32_t file);
    void place_region(std::uint32_t file, std::vector<ChunkRef>& chunks);
    [[nodiscard]] Bytes read_external(const ChunkRef& chunk, Compression compression,
                                      Reader& reader) const;
    [[nodiscard]] const std::string& path_of(std::uint32_t file) const noexcept {
        return m_source.entries()[m_files[file].entry].path;
    }

    FileSource& m_source;
    std::vector<ChunkFile> m_files;
    std::vector<ChunkRef> m_chunks;
    std::vector<std::string> m_damage;
    std::vector<std::string> m_notes;
};

}  // namespace terravox::minecraft
