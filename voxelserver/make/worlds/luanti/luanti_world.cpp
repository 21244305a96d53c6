#include "voxelserver/make/worlds/luanti/luanti_world.hpp"

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "common/util/cache.hpp"
#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "common/util/text.hpp"
#include "common/voxel/pyramid_world.hpp"
#include "voxelserver/make/worlds/luanti/block_survey.hpp"
#include "voxelserver/make/worlds/luanti/node_block.hpp"

namespace terravox::luanti {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMapName = "map.sqlite";
constexpr const char* kSettingsName = "world.mt";
constexpr std::size_t kMaxSettingsBytes = std::size_t{1} << 20;

using Settings = std::map<std::string, std::string, std::less<>>;

/// The lines `key = value` of a world.mt; other lines are ignored.
Settings read_settings(const fs::path& file) {
    const std::string text =
        util::read_text(file, kMaxSettingsBytes, "read the world's settings " + file.string());
    Settings out;
    for (std::string_view left = text; !left.empty();) {
        const auto end = left.find('\n');
        const std::string_view line = left.substr(0, end);
        left.remove_prefix(end == std::string_view::npos ? left.size() : end + 1);
        if (const auto equal = line.find('='); equal != std::string_view::npos)
            out[std::string(util::trimmed(line.substr(0, equal)))] =
                util::trimmed(line.substr(equal + 1));
    }
    return out;
}

/// @param allowed the one supported value, which is also the game's default
void check(const fs::path& folder, const Settings& settings, const char* key,
           const std::string& allowed) {
    const auto found = settings.find(key);
    if (found == settings.end() || found->second == allowed)
        return;
    throw util::UsageError("open the Luanti world {}: {} = {} in its world.mt; allowed: {}",
                           folder.string(), key, found->second, allowed);
}

std::string find_value(const Settings& settings, std::string_view key) {
    const auto found = settings.find(key);
    return found == settings.end() ? std::string{} : found->second;
}

std::string name_of_folder(const fs::path& folder) {
    const fs::path full = fs::absolute(folder).lexically_normal();
    return (full.has_filename() ? full : full.parent_path()).filename().string();
}

}  // namespace

bool looks_like_luanti(const fs::path& path) noexcept {
    try {
        std::error_code failed;
        if (fs::is_directory(path, failed))
            return fs::is_regular_file(path / kSettingsName, failed) &&
                   !fs::exists(path / "level.dat", failed);
        return path.filename() == kMapName && fs::is_regular_file(path, failed);
    } catch (...) {
        return false;
    }
}

WorldFiles find_world_files(const fs::path& path) {
    std::error_code failed;
    const bool is_folder = fs::is_directory(path, failed);
    const fs::path folder = is_folder ? path : fs::absolute(path).parent_path();
    Settings settings;
    if (fs::is_regular_file(folder / kSettingsName, failed))
        settings = read_settings(folder / kSettingsName);
    check(folder, settings, "blocksize", "16");
    if (is_folder)
        check(folder, settings, "backend", "sqlite3");
    WorldFiles out;
    out.map = folder / kMapName;
    out.title = find_value(settings, "world_name");
    out.game = find_value(settings, "gameid");
    if (out.title.empty())
        out.title = name_of_folder(folder);
    if (!fs::is_regular_file(out.map, failed))
        throw util::UsageError(
            "open the Luanti world {}: no map.sqlite; allowed: a world that the game has saved",
            folder.string());
    return out;
}

namespace {

using voxel::BoxKey;
using voxel::FineColumn;
using voxel::floor_div;

constexpr std::size_t kMinMemoryBytes = std::size_t{16} << 20;

// The beginning of messages.
std::string opening(const LuantiWorldOptions& options) {
    return "open the Luanti world " + options.path.string() + ": ";
}

/// Blocks are decoded once for all the boxes that they touch, and kept under a byte limit.
class LuantiWorld final : public voxel::PyramidWorld {
public:
    LuantiWorld(const LuantiWorldOptions& options, const minecraft::BlockTable& nodes)
        : PyramidWorld(options.memory_bytes / 2),
          m_files(find_world_files(options.path)),
          m_database(m_files.map),
          m_appearances(nodes),
          m_blocks(options.memory_bytes / 4) {
        BlockSurvey survey = survey_blocks(m_database, m_appearances, m_damage, options.threads,
                                           options.max_surveyed);
        if (survey.blocks == 0 && m_damage.lines().empty())
            throw util::UsageError(opening(options) +
                                   "it has no map blocks; allowed: at least one");
        if (survey.damaged == survey.looked_at)
            throw util::Error("{}none of its map blocks can be read; the first reason: {}",
                              opening(options), m_damage.lines().front());
        m_info.title = m_files.title;
        m_info.bounds = survey.bounds;
        m_info.framed = survey.framed;
        m_info.levels = levels_for(m_info.bounds);
        m_index = std::move(survey.index);
    }

    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_info; }
    [[nodiscard]] std::vector<std::string> damage() const override { return m_damage.lines(); }

protected:
    [[nodiscard]] FineColumn make_column(std::int32_t bx, std::int32_t bz) override {
        const BlockIndex::Heights heights = m_index.heights(bx, bz);
        FineColumn out;
        if (heights.begin == heights.end)
            return out;
        out.by_begin = floor_div(heights.begin, BoxBlocks::kHigh);
        const std::int32_t by_end = floor_div(heights.end - 1, BoxBlocks::kHigh) + 1;
        MapBlockReader reader;
        for (std::int32_t by = out.by_begin; by < by_end; ++by)
            out.boxes.push_back(make_box({0, bx, by, bz}, reader));
        return out;
    }

    [[nodiscard]] bool may_hold_column(int level, std::int32_t bx, std::int32_t bz) const override {
        return m_index.holds(level, bx, bz);
    }

private:
    // The blocks around matter only where the box holds anything, and only those that share a face
    // with it.
    std::shared_ptr<const voxel::Box> make_box(const BoxKey& key, MapBlockReader& reader) {
        BoxBlocks blocks;
        bool holds_any = false;
        const auto load = [&](int sides) {
            for (int y = -1; y <= BoxBlocks::kHigh; ++y) {
                for (int z = -1; z <= BoxBlocks::kAcross; ++z) {
                    for (int x = -1; x <= BoxBlocks::kAcross; ++x) {
                        if (BoxBlocks::sides_passed(x, y, z) != sides)
                            continue;
                        blocks.at(x, y, z) =
                            block({key.bx * BoxBlocks::kAcross + x, key.by * BoxBlocks::kHigh + y,
                                   key.bz * BoxBlocks::kAcross + z},
                                  reader);
                        holds_any = holds_any || blocks.at(x, y, z) != nullptr;
                    }
                }
            }
        };
        load(0);
        if (!holds_any)
            return nullptr;
        load(1);
        return to_box(blocks, key);
    }

    // nullptr: air, because the block does not exist, or is damaged.
    std::shared_ptr<const NodeBlock> block(const BlockPlace& place, MapBlockReader& reader) {
        const BlockIndex::Heights heights = m_index.heights(floor_div(place.x, BoxBlocks::kAcross),
                                                            floor_div(place.z, BoxBlocks::kAcross));
        if (place.y < heights.begin || place.y >= heights.end)
            return nullptr;
        return m_blocks.get(
            place, [&] { return read(place, reader); },
            [](const auto& made) { return made ? made->memory_bytes() : 0; });
    }

    std::shared_ptr<const NodeBlock> read(const BlockPlace& place, MapBlockReader& reader) {
        try {
            const std::vector<std::uint8_t> blob = m_database.read(place);
            return blob.empty() ? nullptr : make_node_block(reader.read(blob), m_appearances);
        } catch (const util::Error& e) {
            m_damage.add(to_name(place) + ": " + e.what());
            return nullptr;
        }
    }

    const WorldFiles m_files;
    MapDatabase m_database;
    NodeAppearances m_appearances;
    worlds::DamageLog m_damage;
    voxel::WorldInfo m_info;
    BlockIndex m_index;
    util::Cache<BlockPlace, NodeBlock, BlockPlaceHash> m_blocks;
};

}  // namespace

std::unique_ptr<voxel::World> open_luanti_world(const LuantiWorldOptions& options,
                                                const minecraft::BlockTable& nodes) {
    if (options.memory_bytes < kMinMemoryBytes)
        throw util::UsageError("{}{} MiB of memory; allowed: at least {}", opening(options),
                               options.memory_bytes >> 20, kMinMemoryBytes >> 20);
    if (options.max_surveyed == 0)
        throw util::UsageError(opening(options) +
                               "looks through 0 map blocks; allowed: at least 1");
    return std::make_unique<LuantiWorld>(options, nodes);
}

}  // namespace terravox::luanti
