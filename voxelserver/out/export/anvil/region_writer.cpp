#include "voxelserver/out/export/anvil/region_writer.hpp"

#include <libdeflate.h>
#include <algorithm>
#include <bit>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"

namespace terravox::exports::anvil {

using voxel::Material;

namespace {

constexpr int kQuarts = 4;  // cells of biomes along an edge of a section

/// Packs values of `bits` bits into longs, lowest first; none lies across two longs.
class Packer {
public:
    explicit Packer(int bits) : m_bits(bits) {}
    void add(std::uint64_t value) {
        if (m_used + m_bits > 64)
            flush();
        m_word |= value << m_used;
        m_used += m_bits;
    }
    [[nodiscard]] const std::vector<std::uint64_t>& longs() {
        if (m_used > 0)
            flush();
        return m_longs;
    }

private:
    void flush() {
        m_longs.push_back(m_word);
        m_word = 0;
        m_used = 0;
    }
    const int m_bits;
    int m_used = 0;
    std::uint64_t m_word = 0;
    std::vector<std::uint64_t> m_longs;
};

int bits_for(std::size_t count) noexcept {
    return std::bit_width(count - 1);
}

}  // namespace

std::string_view choose_biome(std::span<const Material, 16> tops) noexcept {
    std::array<int, voxel::kMaterialCount> count{};
    int columns = 0;
    for (const Material m : tops)
        if (m != Material::kAir) {
            ++count[static_cast<std::size_t>(m)];
            ++columns;
        }
    const auto share = [&](std::initializer_list<Material> of) {
        int n = 0;
        for (const Material m : of)
            n += count[static_cast<std::size_t>(m)];
        return n * 2 >= columns;
    };
    if (columns == 0)
        return "minecraft:the_void";
    if (share({Material::kHighVegetation, Material::kTrunk}))
        return "minecraft:forest";
    if (share({Material::kWater}))
        return "minecraft:river";
    if (share({Material::kSnow, Material::kIce}))
        return "minecraft:snowy_plains";
    if (share({Material::kSand}))
        return "minecraft:desert";
    return "minecraft:plains";
}

ChunkWriter::ChunkWriter(const ExportBlocks& blocks, const Place& place)
    : m_blocks(blocks),
      m_place(place),
      m_rooted_above(blocks.all().size()),
      m_rooted(blocks.all().size()),
      m_place_in_palette(blocks.all().size()) {
    for (std::size_t id = 1; id < blocks.all().size(); ++id) {
        const Material material = blocks.all()[id].material;
        m_rooted_above[id] = material == Material::kGrass || material == Material::kSoil;
        m_rooted[id] =
            id == blocks.plain(material) ? blocks.rooted(material) : static_cast<BlockId>(id);
    }
}

void ChunkWriter::root_plants(std::vector<Section>& sections) const {
    std::array<BlockId, 256> below{};
    for (std::size_t s = 0; s < sections.size(); ++s) {
        Section& section = sections[s];
        for (std::size_t i = 0; i < (section.uniform ? below.size() : Section::kBlocks); ++i) {
            const BlockId id = section.at(i);
            BlockId& under = below[i & 255];
            const BlockId rooted = m_rooted[id];
            if (rooted != id && under == rooted) {
                // It stands on another plant of its kind: both become a bush instead.
                if (i >= below.size())
                    section.blocks[i - below.size()] = id;
                else if (s > 0)
                    sections[s - 1].blocks[Section::kBlocks - below.size() + i] = id;
            }
            // A uniform section offers no ground for roots except the section below; plants 16 high
            // are trees.
            if (rooted != id && m_rooted_above[under] && !section.uniform)
                section.blocks[i] = under = rooted;
            else
                under = id;
        }
    }
}

std::uint64_t ChunkWriter::survey_sections(const std::vector<Section>& sections) {
    m_top.fill(Material::kAir);
    std::uint64_t solid = 0;
    for (const Section& section : sections) {
        if (section.air())
            continue;
        for (std::size_t i = 0; i < Section::kBlocks; ++i)
            if (const BlockId id = section.at(i); id != 0) {
                ++solid;
                m_top[i & 255] = m_blocks.all()[id].material;
            }
    }
    return solid;
}

void ChunkWriter::put_state(BlockId id) {
    const ExportBlock& block = m_blocks.all()[id];
    m_nbt.put_string("Name", block.name);
    if (!block.properties.empty()) {
        m_nbt.begin("Properties");
        for (const auto& [name, value] : block.properties)
            m_nbt.put_string(name, value);
        m_nbt.end();
    }
    m_nbt.end();
}

void ChunkWriter::put_blocks(const Section& section) {
    m_nbt.begin("block_states");
    if (section.uniform) {
        m_nbt.list("palette", NbtTag::kCompound, 1);
        put_state(section.blocks[0]);
        m_nbt.end();
        return;
    }
    std::vector<BlockId> palette;
    for (const BlockId id : section.blocks) {
        if (m_place_in_palette[id] != 0)
            continue;
        palette.push_back(id);
        m_place_in_palette[id] = static_cast<std::uint16_t>(palette.size());
    }
    m_nbt.list("palette", NbtTag::kCompound, static_cast<std::int32_t>(palette.size()));
    for (const BlockId id : palette)
        put_state(id);
    if (palette.size() > 1) {
        Packer packer(std::max(4, bits_for(palette.size())));
        for (const BlockId id : section.blocks)
            packer.add(std::uint64_t{m_place_in_palette[id]} - 1);
        m_nbt.put_longs("data", packer.longs());
    }
    for (const BlockId id : palette)
        m_place_in_palette[id] = 0;
    m_nbt.end();
}

std::string ChunkWriter::biomes() const {
    std::vector<std::string_view> palette;
    std::array<std::size_t, kQuarts * kQuarts> cells{};
    for (int qz = 0; qz < kQuarts; ++qz)
        for (int qx = 0; qx < kQuarts; ++qx) {
            std::array<Material, 16> tops;
            for (int i = 0; i < 16; ++i)
                tops[static_cast<std::size_t>(i)] =
                    m_top[static_cast<std::size_t>((qz * 4 + i / 4) * 16 + qx * 4 + i % 4)];
            const std::string_view biome = choose_biome(tops);
            const auto found = std::find(palette.begin(), palette.end(), biome);
            cells[static_cast<std::size_t>(qz * kQuarts + qx)] =
                static_cast<std::size_t>(found - palette.begin());
            if (found == palette.end())
                palette.push_back(biome);
        }
    NbtWriter out;
    out.begin("biomes");
    out.list("palette", NbtTag::kString, static_cast<std::int32_t>(palette.size()));
    for (const std::string_view biome : palette)
        out.value_string(biome);
    if (palette.size() > 1) {
        Packer packer(bits_for(palette.size()));
        for (int y = 0; y < kQuarts; ++y)
            for (const std::size_t cell : cells)
                packer.add(cell);
        out.put_longs("data", packer.longs());
    }
    out.end();
    return out.bytes();
}

std::string ChunkWriter::chunk(std::int32_t x, std::int32_t z, std::vector<Section>& sections) {
    if (std::all_of(sections.begin(), sections.end(), [](const Section& s) { return s.air(); }))
        return {};
    root_plants(sections);
    const std::uint64_t solid = survey_sections(sections);
    if (solid == 0)
        return {};
    m_voxels += solid;
    const std::string biome_tag = biomes();
    m_nbt.clear();
    m_nbt.begin("");
    m_nbt.put_int("DataVersion", kDataVersion);
    m_nbt.put_int("xPos", x);
    m_nbt.put_int("zPos", z);
    m_nbt.put_int("yPos", m_place.first_section());
    m_nbt.put_string("Status", "minecraft:full");
    m_nbt.put_byte("isLightOn", 0);
    m_nbt.put_long("LastUpdate", 0);
    m_nbt.put_long("InhabitedTime", 0);
    m_nbt.list("sections", NbtTag::kCompound, static_cast<std::int32_t>(sections.size()));
    for (std::size_t i = 0; i < sections.size(); ++i) {
        m_nbt.put_byte(
            "Y", static_cast<std::int8_t>(m_place.first_section() + static_cast<std::int32_t>(i)));
        put_blocks(sections[i]);
        m_nbt.raw(biome_tag);
        m_nbt.end();
    }
    for (const char* empty : {"block_entities", "block_ticks", "fluid_ticks"})
        m_nbt.list(empty, NbtTag::kEnd, 0);
    m_nbt.begin("Heightmaps");
    m_nbt.end();
    m_nbt.begin("structures");
    for (const char* empty : {"References", "starts"}) {
        m_nbt.begin(empty);
        m_nbt.end();
    }
    m_nbt.end();
    m_nbt.end();
    return m_nbt.bytes();
}

namespace {

constexpr std::size_t kSector_bytes = 4096;
constexpr std::size_t kMaxSectors = 255;
constexpr std::size_t kChunkHeader_bytes = 5;
constexpr int kChunksAlong = 32;
constexpr char kZlib = 2;
constexpr char kExternal = static_cast<char>(0x80);

std::size_t count_sectors(std::size_t bytes) noexcept {
    return (bytes + kSector_bytes - 1) / kSector_bytes;
}

void put_big_endian(std::string& out, std::size_t at, std::uint32_t value) {
    for (int i = 0; i < 4; ++i)
        out[at + static_cast<std::size_t>(i)] = static_cast<char>(value >> (24 - 8 * i) & 0xff);
}

/// Place of a chunk in the table of its region.
std::size_t find_slot(const PackedChunk& chunk) noexcept {
    return static_cast<std::size_t>((chunk.z & (kChunksAlong - 1)) * kChunksAlong +
                                    (chunk.x & (kChunksAlong - 1)));
}

}  // namespace

struct Compressor::Impl {
    libdeflate_compressor* deflate = libdeflate_alloc_compressor(6);
    ~Impl() { libdeflate_free_compressor(deflate); }
};

Compressor::Compressor() : m_impl(std::make_unique<Impl>()) {
    if (m_impl->deflate == nullptr)
        throw util::Error("compress chunks: out of memory");
}
Compressor::~Compressor() = default;

std::string Compressor::zlib(std::string_view bytes) {
    std::string out(libdeflate_zlib_compress_bound(m_impl->deflate, bytes.size()), '\0');
    out.resize(libdeflate_zlib_compress(m_impl->deflate, bytes.data(), bytes.size(), out.data(),
                                        out.size()));
    return out;
}

std::string Compressor::gzip(std::string_view bytes) {
    std::string out(libdeflate_gzip_compress_bound(m_impl->deflate, bytes.size()), '\0');
    out.resize(libdeflate_gzip_compress(m_impl->deflate, bytes.data(), bytes.size(), out.data(),
                                        out.size()));
    return out;
}

std::uint64_t write_region(const std::filesystem::path& folder, std::int32_t rx, std::int32_t rz,
                           std::vector<PackedChunk> chunks) {
    std::sort(chunks.begin(), chunks.end(), [](const PackedChunk& a, const PackedChunk& b) {
        return find_slot(a) < find_slot(b);
    });
    std::uint64_t written = 0;
    // Two sectors of tables: the places of the chunks, and their times of writing (none, so that
    // the same world gives the same bytes).
    std::string out(2 * kSector_bytes, '\0');
    for (const PackedChunk& chunk : chunks) {
        const bool external = count_sectors(chunk.zlib.size() + kChunkHeader_bytes) > kMaxSectors;
        if (external) {
            util::write_file_atomically(
                folder / ("c." + std::to_string(chunk.x) + "." + std::to_string(chunk.z) + ".mcc"),
                chunk.zlib, util::Links::kReplace);
            written += chunk.zlib.size();
        }
        const std::string_view inside =
            external ? std::string_view() : std::string_view(chunk.zlib);
        const std::size_t at = out.size();
        const std::size_t sectors = count_sectors(inside.size() + kChunkHeader_bytes);
        put_big_endian(out, find_slot(chunk) * 4,
                       static_cast<std::uint32_t>(at / kSector_bytes << 8 | sectors));
        out.resize(at + kChunkHeader_bytes);
        put_big_endian(out, at, static_cast<std::uint32_t>(inside.size() + 1));
        out[at + 4] = static_cast<char>(external ? kZlib | kExternal : kZlib);
        out += inside;
        out.resize(at + sectors * kSector_bytes);
    }
    util::write_file_atomically(
        folder / ("r." + std::to_string(rx) + "." + std::to_string(rz) + ".mca"), out,
        util::Links::kReplace);
    return written + out.size();
}

}  // namespace terravox::exports::anvil
