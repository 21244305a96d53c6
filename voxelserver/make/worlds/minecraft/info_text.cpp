#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/util/printable.hpp"
#include "voxelserver/make/worlds/minecraft/blocks/block_table.hpp"
#include "voxelserver/make/worlds/minecraft/info.hpp"

namespace terravox::minecraft {
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

std::string text_of(const DimensionFacts& d, const BlockTable* blocks) {
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

json json_of(const DimensionFacts& d) {
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
        out += text_of(dimension, blocks);
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
        out["dimensions"].push_back(json_of(dimension));
    return out.dump(2, ' ', true, json::error_handler_t::replace);
}

}  // namespace terravox::minecraft
