#include <array>
#include <map>
#include <nlohmann/json.hpp>

#include "voxelserver/out/export/anvil/write_anvil.hpp"

namespace terravox::exports::anvil {
namespace {

using nlohmann::json;

// Versions of the game that describe a dimension alike, by the format of their data packs. The last
// has no end: a later game that passed over the pack would cut the world off.
struct Generation {
    const char* folder;
    int first, last;
};
constexpr Generation kTo1_21_10{"to_1_21_10", 48, 89};
constexpr Generation kFrom1_21_11{"from_1_21_11", 90, 94};
constexpr Generation kFrom26_1{"from_26_1", 95, 9999};
constexpr std::array kGenerations{kTo1_21_10, kFrom1_21_11, kFrom26_1};
constexpr int kLastWithoutMinor = 81;  // 1.21.8: since then formats are first and last

// The overworld's, with other heights. Monsters spawn only in the dark, written in the one form
// that all versions read.
json find_dimension_type(const Place& place, const Generation& generation) {
    json out = {{"ambient_light", 0.0},
                {"coordinate_scale", 1.0},
                {"has_ceiling", false},
                {"has_skylight", true},
                {"height", place.height},
                {"infiniburn", "#minecraft:infiniburn_overworld"},
                {"logical_height", place.height},
                {"min_y", place.min_y},
                {"monster_spawn_block_light_limit", 0},
                {"monster_spawn_light_level", 0}};
    if (generation.first < kFrom1_21_11.first) {
        out.update({{"bed_works", true},
                    {"effects", "minecraft:overworld"},
                    {"has_raids", true},
                    {"natural", true},
                    {"piglin_safe", false},
                    {"respawn_anchor_works", false},
                    {"ultrawarm", false}});
        return out;
    }
    // Without its colours the sky is black and has no clouds; without timelines the sun stands
    // still.
    const json cave = {{"block_search_extent", 8},
                       {"offset", 2.0},
                       {"sound", "minecraft:ambient.cave"},
                       {"tick_delay", 6000}};
    const auto music = [](const char* sound) {
        return json{{"max_delay", 24000}, {"min_delay", 12000}, {"sound", sound}};
    };
    out["attributes"] = {{"minecraft:audio/ambient_sounds", {{"mood", cave}}},
                         {"minecraft:audio/background_music",
                          {{"creative", music("minecraft:music.creative")},
                           {"default", music("minecraft:music.game")}}},
                         {"minecraft:gameplay/nether_portal_spawns_piglin", true},
                         {"minecraft:visual/cloud_color", "#ccffffff"},
                         {"minecraft:visual/fog_color", "#c0d8ff"},
                         {"minecraft:visual/sky_color", "#78a7ff"}};
    out["timelines"] = "#minecraft:in_overworld";
    if (generation.first >= kFrom26_1.first) {
        out["attributes"]["minecraft:visual/ambient_light_color"] = "#0a0a0a";
        out["default_clock"] = "minecraft:overworld";
        out["has_ender_dragon_fight"] = false;
    }
    return out;
}

// Games to 1.21.8 read `formats` and `supported_formats`, later ones the two bounds, and refuse a
// pack for both kinds that lacks either.
json find_metadata() {
    json entries = json::array();
    for (const Generation& g : kGenerations)
        entries.push_back({{"directory", g.folder},
                           {"formats", {g.first, g.last}},
                           {"max_format", g.last},
                           {"min_format", g.first}});
    return {{"overlays", {{"entries", entries}}},
            {"pack",
             {{"description", "Heights of a world written by Terravox"},
              {"max_format", kGenerations.back().last},
              {"min_format", kGenerations.front().first},
              {"pack_format", kGenerations.front().first},
              {"supported_formats", {kGenerations.front().first, kLastWithoutMinor}}}}};
}

}  // namespace

std::map<std::string, std::string> height_pack(const Place& place) {
    std::map<std::string, std::string> out{{"pack.mcmeta", find_metadata().dump(2) + "\n"}};
    for (const Generation& g : kGenerations)
        out[std::string(g.folder) + "/data/minecraft/dimension_type/overworld.json"] =
            find_dimension_type(place, g).dump(2) + "\n";
    return out;
}

}  // namespace terravox::exports::anvil
