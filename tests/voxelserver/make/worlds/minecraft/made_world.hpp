#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <random>
#include <string>

#include "common/voxel/world.hpp"
#include "tests/voxelserver/make/worlds/minecraft/made_chunk.hpp"
#include "tests/voxelserver/make/worlds/minecraft/made_files.hpp"
#include "tests/voxelserver/make/worlds/voxels.hpp"
#include "voxelserver/make/worlds/minecraft/blocks/block_table.hpp"
#include "voxelserver/make/worlds/minecraft/minecraft_world.hpp"
#include "voxelserver/make/worlds/minecraft/place_names.hpp"

namespace terravox::test {

/// The tables that ship with the programs.
inline const minecraft::BlockTable& shipped_blocks() {
    static const minecraft::BlockTable table = minecraft::BlockTable::load(
        std::filesystem::path(TERRAVOX_SOURCE_DIR) / "config" / "blocks");
    return table;
}

inline std::unique_ptr<voxel::World> open_made(const std::filesystem::path& path,
                                               const std::string& dimension = "overworld",
                                               int threads = 2) {
    return minecraft::open_minecraft_world({path, dimension, std::size_t{64} << 20, threads},
                                           shipped_blocks());
}

/// Some chunks, and the files that they make.
struct MadeWorld {
    std::map<std::pair<int, int>, MadeChunk> chunks;  ///< by x, z

    MadeChunk& chunk(int x, int z) {
        MadeChunk& out = chunks[{x, z}];
        out.x = x;
        out.z = z;
        return out;
    }
    [[nodiscard]] std::uint16_t at(int x, int y, int z) const {
        const auto found = chunks.find({voxel::floor_div(x, 16), voxel::floor_div(z, 16)});
        return found == chunks.end() ? 0 : found->second.at(x & 15, y, z & 15);
    }
    /// Regions by their name within the world's folder.
    [[nodiscard]] std::map<std::string, Bytes> files(Made made, int kind = 2) const {
        std::map<std::string, MadeRegion> regions;
        const std::string ending = made == Made::kColumns ? ".mcr" : ".mca";
        for (const auto& [place, chunk] : chunks) {
            const std::string name = "region/r." + std::to_string(voxel::floor_div(chunk.x, 32)) +
                                     "." + std::to_string(voxel::floor_div(chunk.z, 32)) + ending;
            regions[name].put((chunk.x & 31) + 32 * (chunk.z & 31), chunk_nbt(chunk, made), kind);
        }
        std::map<std::string, Bytes> out;
        for (auto& [name, region] : regions)
            out[name] = std::move(region.bytes);
        return out;
    }
};

inline void write_files(const std::filesystem::path& folder,
                        const std::map<std::string, Bytes>& files) {
    for (const auto& [name, bytes] : files)
        write_bytes(folder / name, bytes);
}

/// A few chunks around a corner of boxes: layered ground with holes, water and glass, and some that
/// lack.
inline MadeWorld random_world(std::uint64_t seed, int low_y, int high_y) {
    std::mt19937_64 random(seed);
    MadeWorld world;
    for (int cz = -2; cz < 6; ++cz)
        for (int cx = -3; cx < 3; ++cx) {
            if (random() % 7 == 0)
                continue;
            MadeChunk& chunk = world.chunk(cx, cz);
            for (int z = 0; z < 16; ++z)
                for (int x = 0; x < 16; ++x) {
                    const int top =
                        low_y + static_cast<int>(random() % static_cast<unsigned>(high_y - low_y));
                    for (int y = low_y; y < top; ++y) {
                        const std::size_t block = random() % 40 == 0 ? random() % kMadeBlocks.size()
                                                  : y < top - 3      ? 1u
                                                                     : 2u;
                        chunk.set(x, y, z, static_cast<std::uint16_t>(block));
                    }
                }
        }
    return world;
}

inline voxel::Material to_material(std::uint16_t block) {
    static const auto materials = [] {
        std::array<voxel::Material, kMadeBlocks.size()> out;
        for (std::size_t i = 0; i < out.size(); ++i)
            out[i] = shipped_blocks().of(kMadeBlocks[i].name, {}).material;
        return out;
    }();
    return materials[block];
}

/// How many voxels of the world are not what was put there.
/// @param offset world voxel minus the made world's
inline int differing_voxels(voxel::World& world, const MadeWorld& made,
                            const std::array<std::int32_t, 3>& offset = {}) {
    return differing_voxels(world, [&](int x, int y, int z) {
        return to_material(made.at(x - offset[0], y - offset[1], z - offset[2]));
    });
}

}  // namespace terravox::test
