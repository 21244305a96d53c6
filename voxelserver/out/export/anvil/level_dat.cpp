#include "voxelserver/out/export/anvil/write_anvil.hpp"

#include <utility>

#include "voxelserver/out/export/anvil/nbt_writer.hpp"
#include "voxelserver/out/export/anvil/region_writer.hpp"

namespace terravox::exports::anvil {
namespace {

constexpr std::int64_t kNoon = 6000;  // ticks

/// Generator of an empty world around what was written.
void put_void_generator(NbtWriter& nbt) {
    nbt.begin("generator");
    nbt.put_string("type", "minecraft:flat");
    nbt.begin("settings");
    nbt.put_string("biome", "minecraft:the_void");
    nbt.put_byte("features", 0);
    nbt.put_byte("lakes", 0);
    nbt.list("layers", NbtTag::kEnd, 0);
    nbt.list("structure_overrides", NbtTag::kEnd, 0);
    nbt.end();
    nbt.end();
}

void put_noise_generator(NbtWriter& nbt, const char* settings, const char* source,
                         const char* preset) {
    nbt.begin("generator");
    nbt.put_string("type", "minecraft:noise");
    nbt.put_string("settings", settings);
    nbt.begin("biome_source");
    nbt.put_string("type", source);
    if (preset != nullptr)
        nbt.put_string("preset", preset);
    nbt.end();
    nbt.end();
}

void put_generators(NbtWriter& nbt) {
    nbt.begin("WorldGenSettings");
    nbt.put_long("seed", 0);
    nbt.put_byte("bonus_chest", 0);
    nbt.put_byte("generate_features", 0);
    nbt.begin("dimensions");
    nbt.begin("minecraft:overworld");
    nbt.put_string("type", "minecraft:overworld");
    put_void_generator(nbt);
    nbt.end();
    nbt.begin("minecraft:the_nether");
    nbt.put_string("type", "minecraft:the_nether");
    put_noise_generator(nbt, "minecraft:nether", "minecraft:multi_noise", "minecraft:nether");
    nbt.end();
    nbt.begin("minecraft:the_end");
    nbt.put_string("type", "minecraft:the_end");
    put_noise_generator(nbt, "minecraft:end", "minecraft:the_end", nullptr);
    nbt.end();
    nbt.end();
    nbt.end();
}

/// Rules that are not listed keep the game's defaults. Rules that would change the world by
/// themselves are off; the sun stands still until a player changes that.
void put_game_rules(NbtWriter& nbt) {
    nbt.begin("GameRules");
    for (const auto& [rule, value] : {std::pair{"doDaylightCycle", "false"},
                                      {"doFireTick", "false"},
                                      {"doMobSpawning", "false"},
                                      {"doPatrolSpawning", "false"},
                                      {"doTraderSpawning", "false"},
                                      {"doVinesSpread", "false"},
                                      {"doWeatherCycle", "false"},
                                      {"mobGriefing", "false"},
                                      {"spawnRadius", "0"}})
        nbt.put_string(rule, value);
    nbt.end();
}

void put_border(NbtWriter& nbt) {
    nbt.put_double("BorderCenterX", 0);
    nbt.put_double("BorderCenterZ", 0);
    nbt.put_double("BorderDamagePerBlock", 0.2);
    nbt.put_double("BorderSafeZone", 5);
    nbt.put_double("BorderSize", 59'999'968);
    nbt.put_double("BorderSizeLerpTarget", 59'999'968);
    nbt.put_long("BorderSizeLerpTime", 0);
    nbt.put_double("BorderWarningBlocks", 5);
    nbt.put_double("BorderWarningTime", 15);
}

void put_weather(NbtWriter& nbt) {
    constexpr std::int32_t kFair_ticks = 1'000'000;
    nbt.put_int("clearWeatherTime", kFair_ticks);
    nbt.put_byte("raining", 0);
    nbt.put_int("rainTime", 0);
    nbt.put_byte("thundering", 0);
    nbt.put_int("thunderTime", 0);
}

void put_packs(NbtWriter& nbt, const Place& place) {
    nbt.begin("DataPacks");
    nbt.list("Disabled", NbtTag::kEnd, 0);
    nbt.list("Enabled", NbtTag::kString, place.needs_pack() ? 2 : 1);
    nbt.value_string("vanilla");
    if (place.needs_pack())
        nbt.value_string(std::string("file/") + kPackName);
    nbt.end();
}

}  // namespace

std::string level_dat(const std::string& title, const std::array<std::int32_t, 3>& spawn,
                      const Place& place) {
    constexpr std::int8_t kPeaceful = 0;
    constexpr std::int32_t kCreative = 1;
    constexpr std::int32_t kAnvil = 19133;
    NbtWriter nbt;
    nbt.begin("");
    nbt.begin("Data");
    nbt.put_int("version", kAnvil);
    nbt.put_int("DataVersion", kDataVersion);
    nbt.begin("Version");
    nbt.put_int("Id", kDataVersion);
    nbt.put_string("Name", "1.21.1");
    nbt.put_string("Series", "main");
    nbt.put_byte("Snapshot", 0);
    nbt.end();
    nbt.put_string("LevelName", title);
    nbt.put_int("SpawnX", spawn[0]);
    nbt.put_int("SpawnY", spawn[1]);
    nbt.put_int("SpawnZ", spawn[2]);
    nbt.put_float("SpawnAngle", 0);
    nbt.put_int("GameType", kCreative);
    nbt.put_byte("Difficulty", kPeaceful);
    nbt.put_byte("DifficultyLocked", 0);
    nbt.put_byte("allowCommands", 1);
    nbt.put_byte("hardcore", 0);
    nbt.put_byte("initialized", 1);
    nbt.put_byte("WasModded", 0);
    nbt.put_long("LastPlayed", 0);
    nbt.put_long("Time", 0);
    nbt.put_long("DayTime", kNoon);
    put_weather(nbt);
    put_border(nbt);
    put_game_rules(nbt);
    put_generators(nbt);
    put_packs(nbt, place);
    nbt.list("ScheduledEvents", NbtTag::kEnd, 0);
    nbt.begin("CustomBossEvents");
    nbt.end();
    nbt.end();
    nbt.end();
    return nbt.bytes();
}

}  // namespace terravox::exports::anvil
