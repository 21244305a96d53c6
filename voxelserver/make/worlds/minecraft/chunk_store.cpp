#include "voxelserver/make/worlds/minecraft/chunk_store.hpp"

#include <algorithm>
#include <tuple>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "voxelserver/make/worlds/minecraft/chunk.hpp"

namespace terravox::minecraft {
namespace {

constexpr std::uint8_t kExternal = 0x80;
constexpr std::uint64_t kMaxSectors = 255;
constexpr std::size_t kChunkHeadBytes = 5;  // length, without itself; compression

std::uint32_t big_endian(const std::uint8_t* bytes) noexcept {
    return std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 |
           std::uint32_t{bytes[2]} << 8 | bytes[3];
}

}  // namespace

RegionTable read_region_table(std::span<const std::uint8_t> head) {
    if (head.size() < kRegionHeadBytes)
        throw util::Error("{} bytes; a region has {} at least", head.size(), kRegionHeadBytes);
    RegionTable table;
    for (std::size_t i = 0; i < table.size(); ++i)
        table[i] = big_endian(&head[4 * i]);
    return table;
}

PackedChunk read_packed(const ByteFile& region, std::uint32_t location,
                        std::vector<std::uint8_t>& buffer) {
    const std::uint64_t first = location >> 8;
    const std::uint64_t sectors = location & 0xFF;
    const std::uint64_t begin = first * kSectorBytes;
    if (first < 2 || sectors == 0)
        throw util::Error("it lies at sector {}, {} long; allowed: from 2 on, 1 at least", first,
                          sectors);
    if (begin + kChunkHeadBytes > region.size())
        throw util::Error("it lies at byte {}, past the end of the file ({} bytes)", begin,
                          region.size());
    // One read suffices for nearly all chunks; the rest of the sectors after the chunk costs less
    // than a second read.
    buffer.resize(
        static_cast<std::size_t>(std::min(sectors * kSectorBytes, region.size() - begin)));
    region.read(begin, buffer);
    const std::uint64_t length = big_endian(buffer.data());
    const std::uint8_t kind = buffer[4];
    if (length == 0)
        throw util::Error("it has a length of 0");
    if (length + 4 > buffer.size()) {
        // Some versions let a chunk grow beyond the number of sectors that the table can hold; the
        // file states its real length.
        if (sectors != kMaxSectors || length + 4 > region.size() - begin ||
            length > Inflater::kLimitBytes)
            throw util::Error("it has a length of {} in {} bytes of sectors", length,
                              buffer.size());
        buffer.resize(static_cast<std::size_t>(length + 4));
        region.read(begin, buffer);
    }
    const int number = kind & ~kExternal;
    if (number < static_cast<int>(Compression::kGzip) ||
        number > static_cast<int>(Compression::kLz4))
        throw util::Error(
            "it is packed by method {}; allowed: 1 (gzip), 2 (zlib), 3 (none), 4 (lz4)", number);
    PackedChunk out{static_cast<Compression>(number), (kind & kExternal) != 0, {}};
    if (!out.external)
        out.bytes = std::span<const std::uint8_t>(buffer).subspan(
            kChunkHeadBytes, static_cast<std::size_t>(length - 1));
    return out;
}

namespace {

// Region by region, then as in a region's table: the most efficient order of reading.
auto to_order(const ChunkPlace& p) noexcept {
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
        if (!of_file.note.empty())
            m_notes.push_back(std::move(of_file.note));
        of_file = {};
    }
    std::stable_sort(m_chunks.begin(), m_chunks.end(), [](const ChunkRef& a, const ChunkRef& b) {
        return to_order(a.place) < to_order(b.place);
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
        const std::vector<std::uint8_t> head = m_source.head(at.entry, kRegionHeadBytes);
        // The game leaves such a file where it was about to write a region's first chunk.
        if (head.empty()) {
            out.note = find_path(file) + ": an empty file, without chunks";
            return out;
        }
        const RegionTable table = read_region_table(head);
        for (std::int32_t slot = 0; slot < static_cast<std::int32_t>(table.size()); ++slot)
            if (const std::uint32_t location = table[static_cast<std::size_t>(slot)]; location != 0)
                out.chunks.push_back(
                    {{at.x * 32 + (slot & 31), at.z * 32 + (slot >> 5)}, file, location});
        if (!at.placed)
            place_region(file, out.chunks);
    } catch (const util::Error& e) {
        out.damage = find_path(file) + ": " + e.what();
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
                                            return to_order(chunk.place) < to_order(p);
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
    const auto entry = m_source.find(joined(find_folder(find_path(chunk.file)), name));
    if (!entry)
        throw util::Error("it is kept in {}, which is not there", name);
    reader.buffer = m_source.whole(*entry, Inflater::kLimitBytes);
    return {reader.inflater.unpack(compression, reader.buffer), compression};
}

std::string ChunkStore::to_name(const ChunkRef& chunk) const {
    return find_path(chunk.file) + ", chunk " + std::to_string(chunk.place.x) + ", " +
           std::to_string(chunk.place.z);
}

const ChunkBlocks& ChunkReader::read(const ChunkRef& chunk, worlds::DamageLog& damage) {
    const ChunkStore::Bytes bytes = m_store.read(chunk, m_reader);
    m_compression = bytes.compression;
    decode_chunk(bytes.nbt, m_blocks);
    const bool has_place = m_store.find_kind(chunk) != FileKind::kChunk;
    if (has_place && m_blocks.place && *m_blocks.place != chunk.place)
        throw util::Error("it stands at the wrong place: it says that it is chunk {}, {}",
                          m_blocks.place->x, m_blocks.place->z);
    for (const std::string& oddity : m_blocks.oddities)
        damage.add(m_store.to_name(chunk) + ": " + oddity);
    return m_blocks;
}

}  // namespace terravox::minecraft
