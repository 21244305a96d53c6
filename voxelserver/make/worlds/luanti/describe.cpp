#include "voxelserver/make/worlds/luanti/describe.hpp"

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/util/error.hpp"
#include "common/util/printable.hpp"
#include "voxelserver/make/worlds/luanti/block_survey.hpp"
#include "voxelserver/make/worlds/luanti/world_files.hpp"

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

std::string text_of(const WorldFacts& facts) {
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

std::string json_of(const WorldFacts& facts) {
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
        throw util::UsageError("world info --blocks: " + request.input +
                               " is a Luanti world; allowed: a Minecraft world");
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
    return {request.as_json ? json_of(facts) : text_of(facts), !facts.damage.empty()};
}

}  // namespace terravox::luanti
