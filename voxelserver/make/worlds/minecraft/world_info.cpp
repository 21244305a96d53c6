#include "voxelserver/make/worlds/minecraft/world_info.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <set>
#include <unordered_map>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "common/util/handle_pool.hpp"
#include "common/util/text.hpp"
#include "voxelserver/make/worlds/kind/damage_log.hpp"
#include "voxelserver/make/worlds/minecraft/block_appearance_cache.hpp"
#include "voxelserver/make/worlds/minecraft/blocks/block_table.hpp"
#include "voxelserver/make/worlds/minecraft/chunk_store.hpp"
#include "voxelserver/make/worlds/minecraft/nbt.hpp"
#include "voxelserver/make/worlds/minecraft/world_folder.hpp"

namespace terravox::minecraft {
namespace {

struct Release {
    std::int32_t data_version;
    const char* name;
};

constexpr std::array kReleases = {
    Release{169, "1.9"},     Release{175, "1.9.1"},    Release{176, "1.9.2"},
    Release{183, "1.9.3"},   Release{184, "1.9.4"},    Release{510, "1.10"},
    Release{511, "1.10.1"},  Release{512, "1.10.2"},   Release{819, "1.11"},
    Release{921, "1.11.1"},  Release{922, "1.11.2"},   Release{1139, "1.12"},
    Release{1241, "1.12.1"}, Release{1343, "1.12.2"},  Release{1519, "1.13"},
    Release{1628, "1.13.1"}, Release{1631, "1.13.2"},  Release{1952, "1.14"},
    Release{1957, "1.14.1"}, Release{1963, "1.14.2"},  Release{1968, "1.14.3"},
    Release{1976, "1.14.4"}, Release{2225, "1.15"},    Release{2227, "1.15.1"},
    Release{2230, "1.15.2"}, Release{2566, "1.16"},    Release{2567, "1.16.1"},
    Release{2578, "1.16.2"}, Release{2580, "1.16.3"},  Release{2584, "1.16.4"},
    Release{2586, "1.16.5"}, Release{2724, "1.17"},    Release{2730, "1.17.1"},
    Release{2860, "1.18"},   Release{2865, "1.18.1"},  Release{2975, "1.18.2"},
    Release{3105, "1.19"},   Release{3117, "1.19.1"},  Release{3120, "1.19.2"},
    Release{3218, "1.19.3"}, Release{3337, "1.19.4"},  Release{3463, "1.20"},
    Release{3465, "1.20.1"}, Release{3578, "1.20.2"},  Release{3698, "1.20.3"},
    Release{3700, "1.20.4"}, Release{3837, "1.20.5"},  Release{3839, "1.20.6"},
    Release{3953, "1.21"},   Release{3955, "1.21.1"},  Release{4080, "1.21.2"},
    Release{4082, "1.21.3"}, Release{4189, "1.21.4"},  Release{4325, "1.21.5"},
    Release{4435, "1.21.6"}, Release{4438, "1.21.7"},  Release{4440, "1.21.8"},
    Release{4554, "1.21.9"}, Release{4556, "1.21.10"}, Release{4671, "1.21.11"},
    Release{4786, "26.1"},   Release{4788, "26.1.1"},  Release{4790, "26.1.2"},
    Release{4903, "26.2"},   Release{5023, "26.3"}};

}  // namespace

std::string game_version(std::int64_t data_version) {
    const auto after =
        std::upper_bound(kReleases.begin(), kReleases.end(), data_version,
                         [](std::int64_t v, const Release& r) { return v < r.data_version; });
    const std::string number = " (" + std::to_string(data_version) + ")";
    if (after == kReleases.begin())
        return std::string("before ") + kReleases.front().name + number;
    const Release& release = *std::prev(after);
    return release.data_version == data_version ? release.name
                                                : std::string("after ") + release.name + number;
}

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
            const ChunkBlocks& blocks = m_reader.read(chunk, damage);
            add_blocks(chunk, blocks);
            ++(blocks.finished ? m_facts.finished : m_facts.unfinished);
            ++m_facts.states[to_utf8(blocks.status)];
            ++m_facts.compressions[compression_name(m_reader.compression())];
            ++m_facts.versions[find_version(chunk, blocks)];
        } catch (const util::Error& e) {
            ++m_facts.damaged;
            damage.add(m_store.to_name(chunk) + ": " + e.what());
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
    std::string find_version(const ChunkRef& chunk, const ChunkBlocks& blocks) const {
        if (blocks.data_version)
            return game_version(*blocks.data_version);
        if (!blocks.alpha)
            return "Anvil before 1.9";
        return m_store.find_kind(chunk) == FileKind::kMcRegion ? "McRegion" : "Alpha";
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
                m_names[to_utf8(m_name.name)] += m_counts[i];
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

DimensionFacts collect_facts(const WorldFolder& world, const DimensionFolder& dimension,
                             bool with_blocks, int threads) {
    const ChunkStore store(world, dimension, threads);
    DimensionFacts out;
    out.name = dimension.name;
    out.notes = store.notes();
    for (const ChunkFile& file : store.files())
        ++out.files[kind_name(file.kind)];
    worlds::DamageLog damage;
    for (const std::string& line : store.damage())
        damage.add(line);
    const auto chunks = store.chunks();
    util::HandlePool<std::unique_ptr<Tally>> tallies;
    thread::parallel_for((chunks.size() + kBatch - 1) / kBatch, threads, [&](std::size_t batch) {
        const auto tally =
            tallies.borrow([&] { return std::make_unique<Tally>(store, with_blocks); });
        for (std::size_t i = batch * kBatch; i < std::min(chunks.size(), (batch + 1) * kBatch); ++i)
            tally->add(chunks[i], damage);
    });
    tallies.for_each([&](const Tally& tally) { tally.add_to(out); });
    out.damage = damage.lines();
    return out;
}

std::string find_format_by(const std::vector<DimensionFacts>& dimensions) {
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

WorldFacts describe(const std::filesystem::path& path, const std::string& dimension,
                    bool with_blocks, int threads) {
    const WorldFolder world(path, kCacheBytes);
    WorldFacts out;
    out.path = path.string();
    out.root = world.root();
    out.level = world.level();
    out.damage = world.damage();
    const auto add = [&](const DimensionFolder& one) {
        out.dimensions.push_back(collect_facts(world, one, with_blocks, threads));
    };
    if (!dimension.empty())
        add(world.dimension(dimension));
    else
        std::ranges::for_each(world.dimensions(), add);
    out.format = find_format_by(out.dimensions);
    return out;
}

namespace {

using nlohmann::json;
using Counts = std::map<std::string, std::int64_t>;

std::string counted(const Counts& counts) {
    std::string out;
    for (const auto& [name, count] : counts)
        out += (out.empty() ? "" : ", ") + std::to_string(count) + " " +
               (name.empty() ? "none" : name);
    return out;
}

// Most frequent first.
std::vector<std::pair<std::string, std::int64_t>> by_count(const Counts& counts) {
    std::vector<std::pair<std::string, std::int64_t>> out(counts.begin(), counts.end());
    std::stable_sort(out.begin(), out.end(),
                     [](const auto& a, const auto& b) { return a.second > b.second; });
    return out;
}

// "1:0", distinguished from a name by its first character.
bool is_number(const std::string& name) noexcept {
    return !name.empty() && name.front() >= '0' && name.front() <= '9';
}

std::string block_line(const std::string& name, std::int64_t count, const BlockTable* blocks) {
    std::string out = "    " + std::to_string(count) + " " + util::printable(name);
    if (blocks == nullptr)
        return out;
    BlockAppearance appearance;
    if (is_number(name)) {
        const int id = std::stoi(name);
        const int data = std::stoi(name.substr(name.find(':') + 1));
        appearance = blocks->of_number(id, data);
        if (appearance.known)
            out += " " + blocks->name_of_number(id, data);
    } else {
        appearance = blocks->of(name, {});
    }
    return out + (appearance.known
                      ? " (" + std::string(voxel::material_name(appearance.material)) + ")"
                      : " (in no table)");
}

std::string to_text(const DimensionFacts& d, const BlockTable* blocks) {
    std::string out = "dimension " + util::printable(d.name) + "\n";
    const auto line = [&](const std::string& label, const std::string& value) {
        if (!value.empty())
            out += "  " + label + ": " + util::printable(value) + "\n";
    };
    line("files", counted(d.files));
    line("chunks", std::to_string(d.chunks) + ": " + std::to_string(d.finished) + " finished, " +
                       std::to_string(d.unfinished) + " unfinished, " + std::to_string(d.damaged) +
                       " damaged; " + std::to_string(d.empty) + " of them empty");
    if (d.states.size() > 1 || (d.states.size() == 1 && !d.states.begin()->first.empty()))
        line("states", counted(d.states));
    line("written by", counted(d.versions));
    line("packed by", counted(d.compressions));
    if (d.min[0] < d.max[0]) {
        std::string extent;
        std::string sizes;
        for (std::size_t a = 0; a < 3; ++a) {
            extent += (a == 0 ? "" : ", ") + std::string(1, "xyz"[a]) + " " +
                      std::to_string(d.min[a]) + " to " + std::to_string(d.max[a] - 1);
            sizes += (a == 0 ? "" : " x ") + std::to_string(d.max[a] - d.min[a]);
        }
        line("extent", extent + " (" + sizes + " blocks)");
    }
    if (!d.blocks.empty())
        out += "  blocks:\n";
    for (const auto& [name, count] : by_count(d.blocks))
        out += block_line(name, count, blocks) + "\n";
    for (const std::string& damage : d.damage)
        line("damaged", damage);
    for (const std::string& note : d.notes)
        line("note", note);
    return out;
}

json to_json(const DimensionFacts& d) {
    json out = {{"name", d.name},
                {"files", d.files},
                {"chunks",
                 {{"all", d.chunks},
                  {"finished", d.finished},
                  {"unfinished", d.unfinished},
                  {"damaged", d.damaged},
                  {"empty", d.empty}}},
                {"states", d.states},
                {"versions", d.versions},
                {"compressions", d.compressions},
                {"damage", d.damage},
                {"notes", d.notes}};
    out["extent"] = d.min[0] < d.max[0] ? json{{"min", d.min}, {"max", d.max}} : json(nullptr);
    if (!d.blocks.empty())
        out["blocks"] = d.blocks;
    return out;
}

}  // namespace

std::string to_text(const WorldFacts& facts, const BlockTable* blocks) {
    std::string out;
    const auto line = [&](const std::string& label, const std::string& value) {
        if (!value.empty())
            out += label + ": " + util::printable(value) + "\n";
    };
    line("path", facts.path);
    line("folder", facts.root);
    line("format", facts.format);
    if (facts.level) {
        line("name", facts.level->name);
        const std::string data_version =
            facts.level->data_version ? "data version " + std::to_string(*facts.level->data_version)
                                      : "";
        line("version", facts.level->version +
                            (facts.level->version.empty() || data_version.empty() ? "" : ", ") +
                            data_version);
        if (const auto& s = facts.level->spawn)
            line("spawn", std::to_string((*s)[0]) + ", " + std::to_string((*s)[1]) + ", " +
                              std::to_string((*s)[2]));
        if (facts.level->seed)
            line("seed", std::to_string(*facts.level->seed));
    }
    for (const std::string& damage : facts.damage)
        line("damaged", damage);
    for (const DimensionFacts& dimension : facts.dimensions)
        out += to_text(dimension, blocks);
    if (!out.empty())
        out.pop_back();  // the final line feed
    return out;
}

std::string to_json(const WorldFacts& facts) {
    json out = {{"path", facts.path},
                {"root", facts.root},
                {"format", facts.format},
                {"damage", facts.damage},
                {"dimensions", json::array()}};
    if (facts.level) {
        json& level =
            out["level"] = {{"name", facts.level->name}, {"version", facts.level->version}};
        if (facts.level->data_version)
            level["data_version"] = *facts.level->data_version;
        if (facts.level->spawn)
            level["spawn"] = *facts.level->spawn;
        if (facts.level->seed)
            level["seed"] = *facts.level->seed;
    }
    for (const DimensionFacts& dimension : facts.dimensions)
        out["dimensions"].push_back(to_json(dimension));
    return out.dump(2, ' ', true, json::error_handler_t::replace);
}

}  // namespace terravox::minecraft
