#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "voxelserver/make/worlds/minecraft/world_folder.hpp"

namespace terravox::minecraft {

/// The release of the game that a data version belongs to: "1.16.4", or "after 1.16.4 (2600)" for
/// one between.
[[nodiscard]] std::string game_version(std::int64_t data_version);

class BlockTable;

/// Facts about the chunks of one dimension.
struct DimensionFacts {
    std::string name;  ///< "overworld", "nether", "end", "DIM7", "some_pack:moon"
    std::map<std::string, std::int64_t> files;  ///< by kind: "mca", "mcr", "alpha"
    /// Chunks that are listed in the files' tables; each is finished, unfinished (a proto-chunk) or
    /// damaged.
    std::int64_t chunks = 0;
    std::int64_t finished = 0;
    std::int64_t unfinished = 0;
    std::int64_t damaged = 0;
    std::int64_t empty = 0;  ///< of the finished and unfinished: those of nothing but air
    std::map<std::string, std::int64_t> states;  ///< by Status; "" = none, as before 1.13
    /// By game version, or generation of the format where the chunk names none.
    std::map<std::string, std::int64_t> versions;
    std::map<std::string, std::int64_t> compressions;  ///< "gzip", "zlib", "none", "lz4"
    /// Bounds of the blocks that are not air, half-open, in Minecraft's coordinates, x and z to
    /// whole chunks; min = max: none.
    std::array<std::int64_t, 3> min{};
    std::array<std::int64_t, 3> max{};
    /// Count of each block except air, where requested: "minecraft:stone", or "1:0" (id:data) in
    /// chunks of numeric ids.
    std::map<std::string, std::int64_t> blocks;
    std::vector<std::string> damage;  ///< one line each
    std::vector<std::string> notes;   ///< harmless oddities, e.g. regions that were skipped
};

struct WorldFacts {
    /// `format`: "Anvil", "McRegion", "Alpha", "one chunk", or several with "+" between.
    std::string path;
    std::string format;
    std::string root;  ///< folder inside the path that holds the world; empty: the path itself
    /// nullopt: no level.dat, or one that cannot be read (then a line in `damage`).
    std::optional<LevelDat> level;
    std::vector<DimensionFacts> dimensions;
    std::vector<std::string> damage;  ///< of the world as a whole, one line each
};

/// Reads every chunk.
/// @param path as MinecraftWorldOptions::path
/// @param dimension only this one; empty: all
/// @param with_blocks count the blocks, too
/// @param threads 0 = one for each core
/// @throws UsageError for a path without a world, or without that dimension
[[nodiscard]] WorldFacts describe(const std::filesystem::path& path, const std::string& dimension,
                                  bool with_blocks, int threads);

/// Plain text: one fact a line, without a final line feed.
/// @param blocks names numeric ids and lists the blocks that the table does not know; nullptr: ids
/// stay numbers
[[nodiscard]] std::string to_text(const WorldFacts& facts, const BlockTable* blocks = nullptr);
[[nodiscard]] std::string to_json(const WorldFacts& facts);

}  // namespace terravox::minecraft
