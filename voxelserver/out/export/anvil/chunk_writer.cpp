#include "voxelserver/out/export/anvil/chunk_writer.hpp"

#include <algorithm>
#include <bit>

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

std::string_view biome_of(std::span<const Material, 16> tops) noexcept {
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
            const std::string_view biome = biome_of(tops);
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

}  // namespace terravox::exports::anvil
