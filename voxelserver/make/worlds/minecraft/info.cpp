#include "voxelserver/make/worlds/minecraft/info.hpp"

#include <algorithm>
#include <set>
#include <unordered_map>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "voxelserver/make/worlds/kind/damage_log.hpp"
#include "voxelserver/make/worlds/minecraft/block_appearance_cache.hpp"
#include "voxelserver/make/worlds/minecraft/chunk_reader.hpp"
#include "voxelserver/make/worlds/minecraft/game_versions.hpp"
#include "voxelserver/make/worlds/minecraft/nbt.hpp"
#include "voxelserver/make/worlds/minecraft/world_folder.hpp"

namespace terravox::minecraft {
namespace {

constexpr std::size_t kCacheBytes = std::size_t{256} << 20;
constexpr std::size_t kBatch = 32;

bool is_air(std::string_view name) noexcept {
    return name == "minecraft:air" || name == "minecraft:cave_air" ||
           name == "minecraft:void_air" || name == "air";
}

const char* kind_name(FileKind kind) noexcept {
    switch (kind) {
        case FileKind::kAnvil: return "mca";
        case FileKind::kMcRegion: return "mcr";
        case FileKind::kAlpha: return "alpha";
        case FileKind::kChunk: return "chunk";
    }
    return "unknown";
}

/// Facts of some of the chunks; several tallies are added up at the end. Sums only: the order does
/// not matter.
class Tally {
public:
    Tally(const ChunkStore& store, bool with_blocks)
        : m_store(store),
          m_reader(store),
          m_with_blocks(with_blocks),
          m_numbers(with_blocks ? 65536 : 0) {}

    void add(const ChunkRef& chunk, worlds::DamageLog& damage) {
        ++m_facts.chunks;
        try {
            const ChunkBlocks& blocks = m_reader.read(chunk);
            for (const std::string& oddity : blocks.oddities)
                damage.add(m_store.name_of(chunk) + ": " + oddity);
            add_blocks(chunk, blocks);
            ++(blocks.finished ? m_facts.finished : m_facts.unfinished);
            ++m_facts.states[utf8_of(blocks.status)];
            ++m_facts.compressions[compression_name(m_reader.compression())];
            ++m_facts.versions[version_of(chunk, blocks)];
        } catch (const util::Error& e) {
            ++m_facts.damaged;
            damage.add(m_store.name_of(chunk) + ": " + e.what());
        }
    }
    void add_to(DimensionFacts& out) const {
        const auto sum = [](auto& to, const auto& from) {
            for (const auto& [key, count] : from)
                to[key] += count;
        };
        out.chunks += m_facts.chunks;
        out.finished += m_facts.finished;
        out.unfinished += m_facts.unfinished;
        out.damaged += m_facts.damaged;
        out.empty += m_facts.empty;
        sum(out.states, m_facts.states);
        sum(out.versions, m_facts.versions);
        sum(out.compressions, m_facts.compressions);
        sum(out.blocks, m_names);
        for (std::size_t number = 0; number < m_numbers.size(); ++number)
            if (m_numbers[number] != 0 && number >= 16)
                out.blocks[std::to_string(number >> 4) + ":" + std::to_string(number & 15)] +=
                    m_numbers[number];
        if (m_facts.min[0] >= m_facts.max[0])
            return;
        const bool first = out.min[0] >= out.max[0];
        for (std::size_t a = 0; a < 3; ++a) {
            out.min[a] = first ? m_facts.min[a] : std::min(out.min[a], m_facts.min[a]);
            out.max[a] = first ? m_facts.max[a] : std::max(out.max[a], m_facts.max[a]);
        }
    }

private:
    std::string version_of(const ChunkRef& chunk, const ChunkBlocks& blocks) const {
        if (blocks.data_version)
            return game_version(*blocks.data_version);
        if (!blocks.alpha)
            return "Anvil before 1.9";
        return m_store.kind_of(chunk) == FileKind::kMcRegion ? "McRegion" : "Alpha";
    }

    void add_blocks(const ChunkRef& chunk, const ChunkBlocks& blocks) {
        std::int64_t lo = 0;
        std::int64_t hi = 0;
        for (const ChunkSection& section : blocks.sections()) {
            count_cells(blocks, section);
            // The layers that are not empty.
            int lowest = 16;
            int highest = -1;
            for (int y = 0; y < 16; ++y)
                if (layer_holds(section, y)) {
                    lowest = std::min(lowest, y);
                    highest = y;
                }
            if (highest < 0)
                continue;
            if (lo == hi)
                lo = section.y * 16 + lowest;
            hi = section.y * 16 + highest + 1;
        }
        if (lo == hi) {
            ++m_facts.empty;
            return;
        }
        const std::array<std::int64_t, 3> min{std::int64_t{chunk.place.x} * 16, lo,
                                              std::int64_t{chunk.place.z} * 16};
        const std::array<std::int64_t, 3> max{min[0] + 16, hi, min[2] + 16};
        const bool first = m_facts.min[0] >= m_facts.max[0];
        for (std::size_t a = 0; a < 3; ++a) {
            m_facts.min[a] = first ? min[a] : std::min(m_facts.min[a], min[a]);
            m_facts.max[a] = first ? max[a] : std::max(m_facts.max[a], max[a]);
        }
    }

    // Also records which entries of the section's palette are air.
    void count_cells(const ChunkBlocks& blocks, const ChunkSection& section) {
        m_air.assign(section.palette_size, 0);
        if (section.numeric) {
            if (m_with_blocks)
                for (const std::uint16_t number : section.cells)
                    ++m_numbers[number];
            return;
        }
        m_counts.assign(section.palette_size, 0);
        if (section.uniform)
            m_counts[0] = kSectionVoxels;
        else if (m_with_blocks)
            for (const std::uint16_t cell : section.cells)
                ++m_counts[cell];
        for (std::uint32_t i = 0; i < section.palette_size; ++i) {
            palette_name(blocks.palette[section.palette_begin + i], m_name);
            m_air[i] = is_air(m_name.name) ? 1 : 0;
            if (m_with_blocks && m_counts[i] != 0 && m_air[i] == 0)
                m_names[utf8_of(m_name.name)] += m_counts[i];
        }
    }

    [[nodiscard]] bool layer_holds(const ChunkSection& section, int y) const noexcept {
        if (section.uniform)
            return m_air[0] == 0;
        const auto layer = std::span(section.cells).subspan(static_cast<std::size_t>(y) * 256, 256);
        if (section.numeric)
            return std::any_of(layer.begin(), layer.end(),
                               [](std::uint16_t number) { return number >= 16; });
        return std::any_of(layer.begin(), layer.end(),
                           [&](std::uint16_t cell) { return m_air[cell] == 0; });
    }

    const ChunkStore& m_store;
    ChunkReader m_reader;
    bool m_with_blocks;
    DimensionFacts m_facts;
    std::vector<std::int64_t> m_numbers;
    std::vector<std::int64_t> m_counts;
    std::vector<std::uint8_t> m_air;
    std::unordered_map<std::string, std::int64_t> m_names;
    PaletteName m_name;
};

DimensionFacts facts_of(const WorldFolder& world, const DimensionFolder& dimension,
                        const DescribeOptions& options) {
    const ChunkStore store(world, dimension, options.threads);
    DimensionFacts out;
    out.name = dimension.name;
    out.notes = store.notes();
    for (const ChunkFile& file : store.files())
        ++out.files[kind_name(file.kind)];
    worlds::DamageLog damage;
    for (const std::string& line : store.damage())
        damage.add(line);
    const auto chunks = store.chunks();
    Toolbox<Tally> tallies;
    thread::parallel_for(
        (chunks.size() + kBatch - 1) / kBatch, options.threads, [&](std::size_t batch) {
            tallies.with([&] { return std::make_unique<Tally>(store, options.blocks); },
                         [&](Tally& tally) {
                             for (std::size_t i = batch * kBatch;
                                  i < std::min(chunks.size(), (batch + 1) * kBatch); ++i)
                                 tally.add(chunks[i], damage);
                         });
        });
    tallies.for_each([&](const Tally& tally) { tally.add_to(out); });
    out.damage = damage.lines();
    return out;
}

std::string format_of(const std::vector<DimensionFacts>& dimensions) {
    std::set<std::string> kinds;
    for (const DimensionFacts& dimension : dimensions)
        for (const auto& [kind, count] : dimension.files)
            kinds.insert(kind);
    std::string out;
    for (const auto& [kind, name] : {std::pair{"mca", "Anvil"}, std::pair{"mcr", "McRegion"},
                                     std::pair{"alpha", "Alpha"}, std::pair{"chunk", "one chunk"}})
        if (kinds.contains(kind))
            out += (out.empty() ? "" : "+") + std::string(name);
    return out;
}

}  // namespace

WorldFacts describe(const DescribeOptions& options) {
    const WorldFolder world(options.path, kCacheBytes);
    WorldFacts out;
    out.path = options.path.string();
    out.root = world.root();
    out.level = world.level();
    out.damage = world.damage();
    if (!options.dimension.empty())
        out.dimensions.push_back(facts_of(world, world.dimension(options.dimension), options));
    else
        for (const DimensionFolder& dimension : world.dimensions())
            out.dimensions.push_back(facts_of(world, dimension, options));
    out.format = format_of(out.dimensions);
    return out;
}

}  // namespace terravox::minecraft
