#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <tuple>

#include "common/voxel/world.hpp"
#include "tests/voxelserver/data/sqlite/database.hpp"
#include "tests/voxelserver/make/worlds/luanti/made_map_block.hpp"
#include "tests/voxelserver/make/worlds/voxels.hpp"
#include "voxelserver/make/worlds/luanti/luanti_world.hpp"
#include "voxelserver/make/worlds/minecraft/blocks/block_table.hpp"

namespace terravox::test::luanti {

/// How the table of a map.sqlite names the place of a block.
enum class Schema { kEncoded, kXyz };

/// Bytes in a statement.
inline std::string to_sql(const Bytes& bytes) {
    std::string hex;
    for (const std::uint8_t byte : bytes) {
        constexpr char kDigits[] = "0123456789abcdef";
        hex += kDigits[byte >> 4];
        hex += kDigits[byte & 15];
    }
    return "x'" + hex + "'";
}

/// A map.sqlite that is being written.
class MadeMap : public Database {
public:
    MadeMap(const std::filesystem::path& file, Schema schema) : Database(file), m_schema(schema) {
        run(schema == Schema::kEncoded
                ? "CREATE TABLE blocks (pos INT NOT NULL PRIMARY KEY, data BLOB)"
                : "CREATE TABLE blocks (x INTEGER, y INTEGER, z INTEGER, data BLOB NOT NULL, "
                  "PRIMARY KEY (x, z, y))");
        run("BEGIN");
    }
    ~MadeMap() { run("COMMIT"); }
    MadeMap(const MadeMap&) = delete;
    MadeMap& operator=(const MadeMap&) = delete;

    /// @param x, y, z of the block, in the game's axes
    void put(int x, int y, int z, const Bytes& blob) {
        const std::string key =
            m_schema == Schema::kEncoded
                ? std::to_string(z * 16777216LL + y * 4096LL + x)
                : std::to_string(x) + ", " + std::to_string(y) + ", " + std::to_string(z);
        run("INSERT INTO blocks VALUES (" + key + ", " + to_sql(blob) + ")");
    }

private:
    Schema m_schema;
};

/// The table that ships with the programs.
inline const minecraft::BlockTable& shipped_nodes() {
    static const minecraft::BlockTable table = minecraft::BlockTable::load_names(
        std::filesystem::path(TERRAVOX_SOURCE_DIR) / "config" / "blocks" / "luanti.toml");
    return table;
}

inline voxel::Material to_material(const std::string& node) {
    return shipped_nodes().of_full_name(node).material;
}

/// Some blocks, and the files that they make.
struct MadeWorld {
    std::map<std::tuple<int, int, int>, MadeBlock> blocks;  ///< by x, y, z in the game's axes

    /// The node at a place in the game's axes.
    [[nodiscard]] std::string at(int x, int y, int z) const {
        const auto found = blocks.find(
            {voxel::floor_div(x, 16), voxel::floor_div(y, 16), voxel::floor_div(z, 16)});
        if (found == blocks.end())
            return "air";
        return found->second.names[found->second.at(x & 15, y & 15, z & 15)];
    }
    /// @param settings the text of world.mt
    void write(const std::filesystem::path& folder, int version, Schema schema,
               const std::string& settings = "gameid = minetest\nbackend = sqlite3\n") const {
        std::filesystem::create_directories(folder);
        std::ofstream(folder / "world.mt") << settings;
        MadeMap map(folder / "map.sqlite", schema);
        for (const auto& [place, block] : blocks)
            map.put(std::get<0>(place), std::get<1>(place), std::get<2>(place),
                    map_block_blob(block, version));
    }
};

/// Blocks on all sides of the origin: ground with holes, water and glass, some blocks lacking.
inline MadeWorld random_world(std::uint64_t seed) {
    std::mt19937_64 random(seed);
    const std::vector<std::string> names{"air",
                                         "default:stone",
                                         "default:dirt_with_grass",
                                         "default:water_source",
                                         "default:glass",
                                         "default:pine_needles",
                                         "ignore"};
    MadeWorld out;
    for (int z = -2; z < 2; ++z) {
        for (int y = -1; y < 1; ++y) {
            for (int x = -5; x < 1; ++x) {
                if (random() % 7 == 0)
                    continue;
                MadeBlock& block = out.blocks[{x, y, z}];
                block.names = names;
                for (std::uint16_t& id : block.ids)
                    id = random() % 10 == 0 ? static_cast<std::uint16_t>(random() % names.size())
                                            : static_cast<std::uint16_t>(y < 0 ? 1 : 0);
            }
        }
    }
    return out;
}

inline std::unique_ptr<voxel::World> open_made(const std::filesystem::path& path) {
    terravox::luanti::LuantiWorldOptions options;
    options.path = path;
    options.memory_bytes = std::size_t{64} << 20;
    options.threads = 2;
    return terravox::luanti::open_luanti_world(options, shipped_nodes());
}

/// The material of a voxel of the finest level.
inline voxel::Material find_voxel(voxel::World& world, int x, int y, int z) {
    return Voxels(world).material(x, y, z);
}

/// How many voxels are not the node that was put there.
inline int differing_voxels(voxel::World& world, const MadeWorld& made) {
    std::map<std::string, voxel::Material> materials;
    return test::differing_voxels(world, [&](int x, int y, int z) {
        const std::string node = made.at(x, y, -1 - z);
        return materials.try_emplace(node, to_material(node)).first->second;
    });
}

}  // namespace terravox::test::luanti
