#include <array>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "common/util/log.hpp"
#include "common/util/text.hpp"
#include "common/voxel/fingerprint.hpp"
#include "voxelserver/make/worlds/luanti/block_survey.hpp"
#include "voxelserver/make/worlds/luanti/luanti_world.hpp"
#include "voxelserver/make/worlds/minecraft/blocks/block_table.hpp"

namespace terravox::luanti {
namespace {

using nlohmann::json;

/// Of nodes that are not air, half-open, in the game's coordinates.
struct Extent {
    std::array<std::int32_t, 3> min{};
    std::array<std::int32_t, 3> max{};
};

/// All facts that are printed about a world.
struct WorldFacts {
    std::string path;
    WorldFiles files;
    std::string key;  ///< columns of the table's primary key
    BlockSurvey survey;
    std::size_t unknown_nodes = 0;  ///< names that match no entry of the table
    std::vector<std::string> damage;

    [[nodiscard]] Extent extent() const noexcept {
        const voxel::VoxelBounds& b = survey.bounds;
        return {{b.min[0], b.min[1], -b.max[2]}, {b.max[0], b.max[1], -b.min[2]}};
    }
};

std::string line(const std::string& label, const std::string& value) {
    return value.empty() ? std::string{} : label + ": " + util::printable(value) + "\n";
}

std::string text_of_extent(const WorldFacts& facts) {
    if (facts.survey.bounds.empty())
        return {};
    const Extent extent = facts.extent();
    std::string ranges;
    std::string sizes;
    for (std::size_t a = 0; a < 3; ++a) {
        ranges += (a == 0 ? "" : ", ") + std::string(1, "xyz"[a]) + " " +
                  std::to_string(extent.min[a]) + " to " + std::to_string(extent.max[a] - 1);
        sizes += (a == 0 ? "" : " x ") + std::to_string(extent.max[a] - extent.min[a]);
    }
    return ranges + " (" + sizes + " nodes)";
}

std::string text_of_versions(const BlockSurvey& survey) {
    std::string out;
    for (const auto& [version, count] : survey.versions)
        out += (out.empty() ? "" : ", ") + std::to_string(count) + " version " +
               std::to_string(version);
    return out;
}

std::string to_text(const WorldFacts& facts) {
    const BlockSurvey& survey = facts.survey;
    std::string counts = std::to_string(survey.blocks) + ": ";
    if (!survey.complete())
        counts += std::to_string(survey.looked_at) + " looked at, of these ";
    counts += std::to_string(survey.damaged) + " damaged, " + std::to_string(survey.empty) +
              " of nothing but air";
    std::string out = line("path", facts.path);
    out += line("format", "Luanti map in SQLite, key " + facts.key);
    out += line("name", facts.files.title);
    out += line("game", facts.files.game);
    out += line("map blocks", counts);
    out += line("serialization", text_of_versions(survey));
    out += line("extent", text_of_extent(facts));
    if (facts.unknown_nodes > 0)
        out += line("unknown nodes", std::to_string(facts.unknown_nodes) + " in no table");
    for (const std::string& damage : facts.damage)
        out += line("damaged", damage);
    out.pop_back();  // the final line feed
    return out;
}

std::string to_json(const WorldFacts& facts) {
    const BlockSurvey& survey = facts.survey;
    json versions = json::object();
    for (const auto& [version, count] : survey.versions)
        versions[std::to_string(version)] = count;
    json out = {{"path", facts.path},
                {"format", "Luanti"},
                {"key", facts.key},
                {"name", facts.files.title},
                {"game", facts.files.game},
                {"map_blocks",
                 {{"all", survey.blocks},
                  {"looked_at", survey.looked_at},
                  {"damaged", survey.damaged},
                  {"empty", survey.empty}}},
                {"versions", versions},
                {"unknown_nodes", facts.unknown_nodes},
                {"damage", facts.damage}};
    const Extent extent = facts.extent();
    out["extent"] =
        survey.bounds.empty() ? json(nullptr) : json{{"min", extent.min}, {"max", extent.max}};
    return out.dump(2, ' ', true, json::error_handler_t::replace);
}

}  // namespace

worlds::Description describe(const worlds::DescribeRequest& request,
                             const minecraft::BlockTable& nodes) {
    if (request.with_blocks)
        throw util::UsageError(
            "world info --blocks: {} is a Luanti world; allowed: a Minecraft world", request.input);
    WorldFacts facts;
    facts.path = request.input;
    facts.files = find_world_files(request.input);
    MapDatabase database(facts.files.map);
    facts.key = database.is_key_encoded() ? "pos" : "x, y, z";
    NodeAppearances appearances(nodes);
    worlds::DamageLog damage;
    facts.survey =
        survey_blocks(database, appearances, damage, request.threads, kMaxDescribedBlocks);
    facts.unknown_nodes = appearances.unknown_names();
    facts.damage = damage.lines();
    return {request.as_json ? to_json(facts) : to_text(facts), !facts.damage.empty()};
}

}  // namespace terravox::luanti

namespace terravox::worlds {
namespace {

bool is_luanti(const std::string& input) {
    return luanti::looks_like_luanti(input);
}

std::filesystem::path node_table() {
    return util::config_dir() / "blocks" / "luanti.toml";
}

minecraft::BlockTable load_nodes() {
    return minecraft::BlockTable::load_names(node_table());
}

std::unique_ptr<voxel::World> open_luanti(const OpenRequest& request) {
    luanti::LuantiWorldOptions options;
    options.path = request.input();
    options.memory_bytes = request.options.memory_bytes;
    options.threads = request.options.threads;
    auto world = luanti::open_luanti_world(options, load_nodes());
    const auto& b = world->info().bounds;
    util::log_info("Luanti world '{}', {} x {} x {} nodes", world->info().title,
                   b.max[0] - b.min[0], b.max[1] - b.min[1], b.max[2] - b.min[2]);
    return world;
}

// While a server plays a world, it writes to the log file next to the map first.
voxel::Fingerprint state_of_files(const worlds::WorldOptions& options) {
    const luanti::WorldFiles files = luanti::find_world_files(options.inputs.front());
    std::filesystem::path log = files.map;
    log += "-wal";
    voxel::ByteWriter out;
    out.add(files.title);
    std::error_code failed;
    for (const auto& file : {files.map, log, node_table()})
        if (file != log || std::filesystem::exists(log, failed))
            out.add(voxel::file_identity(file, "Luanti world"));
    return out.fingerprint();
}

Description describe_luanti(const DescribeRequest& request) {
    return luanti::describe(request, load_nodes());
}

}  // namespace

constinit const WorldKind kLuantiKind{
    .noun = "a Luanti world",
    .input = "a Luanti (Minetest) world (folder)",
    .recognises = is_luanti,
    .open = open_luanti,
    .describe = describe_luanti,
    .state = state_of_files,
};

}  // namespace terravox::worlds
