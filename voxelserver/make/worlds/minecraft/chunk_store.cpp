#include "voxelserver/make/worlds/minecraft/chunk_store.hpp"

#include <algorithm>
#include <tuple>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "voxelserver/make/worlds/minecraft/chunk.hpp"
#include "voxelserver/make/worlds/minecraft/region_file.hpp"

namespace terravox::minecraft {
namespace {

// Region by region, then as in a region's table: the most efficient order of reading.
auto order_of(const ChunkPlace& p) noexcept {
    return std::tuple(p.x >> 5, p.z >> 5, p.z & 31, p.x & 31);
}

bool stands_alone(FileKind kind) noexcept {
    return kind == FileKind::kAlpha || kind == FileKind::kChunk;
}

}  // namespace

ChunkStore::ChunkStore(const WorldFolder& world, const DimensionFolder& dimension, int threads)
    : m_source(world.source()), m_files(dimension.files), m_notes(dimension.notes) {
    std::vector<Indexed> indexed(m_files.size());
    thread::parallel_for(m_files.size(), threads, [&](std::size_t i) {
        indexed[i] = index_file(static_cast<std::uint32_t>(i));
    });
    for (Indexed& of_file : indexed) {
        m_chunks.insert(m_chunks.end(), of_file.chunks.begin(), of_file.chunks.end());
        if (!of_file.damage.empty())
            m_damage.push_back(std::move(of_file.damage));
        of_file = {};
    }
    std::stable_sort(m_chunks.begin(), m_chunks.end(), [](const ChunkRef& a, const ChunkRef& b) {
        return order_of(a.place) < order_of(b.place);
    });
}

ChunkStore::Indexed ChunkStore::index_file(std::uint32_t file) {
    Indexed out;
    const ChunkFile& at = m_files[file];
    if (stands_alone(at.kind)) {
        out.chunks.push_back({{at.x, at.z}, file, 0});
        if (!at.placed)
            place_region(file, out.chunks);
        return out;
    }
    try {
        const RegionTable table = read_region_table(m_source.head(at.entry, kRegionHeadBytes));
        for (std::int32_t slot = 0; slot < static_cast<std::int32_t>(table.size()); ++slot)
            if (const std::uint32_t location = table[static_cast<std::size_t>(slot)]; location != 0)
                out.chunks.push_back(
                    {{at.x * 32 + (slot & 31), at.z * 32 + (slot >> 5)}, file, location});
        if (!at.placed)
            place_region(file, out.chunks);
    } catch (const util::Error& e) {
        out.damage = path_of(file) + ": " + e.what();
    }
    return out;
}

// For a file whose name does not state its place: the first of its readable chunks does.
void ChunkStore::place_region(std::uint32_t file, std::vector<ChunkRef>& chunks) {
    Reader reader;
    ChunkBlocks blocks;
    for (const ChunkRef& chunk : chunks) {
        try {
            decode_chunk(read(chunk, reader).nbt, blocks);
        } catch (const util::Error&) {
            continue;  // reported when it is read for its blocks
        }
        if (!blocks.place || !within_world(*blocks.place))
            continue;
        const bool alone = stands_alone(m_files[file].kind);
        m_files[file].x = alone ? blocks.place->x : blocks.place->x >> 5;
        m_files[file].z = alone ? blocks.place->z : blocks.place->z >> 5;
        break;
    }
    for (ChunkRef& chunk : chunks) {
        if (stands_alone(m_files[file].kind))
            chunk.place = {m_files[file].x, m_files[file].z};
        else {
            chunk.place.x += m_files[file].x * 32;
            chunk.place.z += m_files[file].z * 32;
        }
    }
}

const ChunkRef* ChunkStore::find(const ChunkPlace& place) const noexcept {
    const auto found = std::lower_bound(m_chunks.begin(), m_chunks.end(), place,
                                        [](const ChunkRef& chunk, const ChunkPlace& p) {
                                            return order_of(chunk.place) < order_of(p);
                                        });
    return found == m_chunks.end() || found->place != place ? nullptr : &*found;
}

ChunkStore::Bytes ChunkStore::read(const ChunkRef& chunk, Reader& reader) const {
    const ChunkFile& file = m_files[chunk.file];
    if (stands_alone(file.kind)) {
        reader.buffer = m_source.whole(file.entry, Inflater::kLimitBytes);
        if (reader.buffer.empty())
            throw util::Error("an empty file");
        const Compression compression = guess_compression(reader.buffer);
        return {reader.inflater.unpack(compression, reader.buffer), compression};
    }
    const PackedChunk packed =
        read_packed(*m_source.open(file.entry), chunk.location, reader.buffer);
    if (packed.external)
        return read_external(chunk, packed.compression, reader);
    return {reader.inflater.unpack(packed.compression, packed.bytes), packed.compression};
}

// Chunks of more than 255 sectors are stored next to their region, since 1.15; named by the chunk's
// place in the world.
ChunkStore::Bytes ChunkStore::read_external(const ChunkRef& chunk, Compression compression,
                                            Reader& reader) const {
    const std::string name =
        "c." + std::to_string(chunk.place.x) + "." + std::to_string(chunk.place.z) + ".mcc";
    const auto entry = m_source.find(joined(folder_of(path_of(chunk.file)), name));
    if (!entry)
        throw util::Error("it is kept in " + name + ", which is not there");
    reader.buffer = m_source.whole(*entry, Inflater::kLimitBytes);
    return {reader.inflater.unpack(compression, reader.buffer), compression};
}

std::string ChunkStore::name_of(const ChunkRef& chunk) const {
    return path_of(chunk.file) + ", chunk " + std::to_string(chunk.place.x) + ", " +
           std::to_string(chunk.place.z);
}

}  // namespace terravox::minecraft
