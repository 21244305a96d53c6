#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tests/voxelserver/make/worlds/minecraft/nbt_writer.hpp"

namespace terravox::test {

/// A block under its name and under its number, which mean the same to the tables.
struct MadeBlock {
    const char* name;
    int id;
};
inline constexpr std::array<MadeBlock, 9> kMadeBlocks = {{{"minecraft:air", 0},
                                                          {"minecraft:stone", 1},
                                                          {"minecraft:dirt", 3},
                                                          {"minecraft:sand", 12},
                                                          {"minecraft:bedrock", 7},
                                                          {"minecraft:glass", 20},
                                                          {"minecraft:gold_block", 41},
                                                          {"minecraft:glowstone", 89},
                                                          {"minecraft:water", 9}}};

/// Cells are indices into kMadeBlocks, at x + 16 z + 256 y.
using MadeSection = std::array<std::uint16_t, 4096>;

struct MadeChunk {
    std::int32_t x = 0;
    std::int32_t z = 0;
    std::map<int, MadeSection> sections;  ///< by y
    std::string status = "full";

    /// Of a column (x, z) of the chunk's own, at a height of the world. Air where there is no
    /// section.
    [[nodiscard]] std::uint16_t at(int column_x, int y, int column_z) const {
        const auto found = sections.find(find_section(y));
        return found == sections.end() ? 0 : found->second[cell(column_x, y, column_z)];
    }
    void set(int column_x, int y, int column_z, std::uint16_t block) {
        sections.try_emplace(find_section(y), MadeSection{})
            .first->second[cell(column_x, y, column_z)] = block;
    }
    static int find_section(int y) { return y >= 0 ? y / 16 : -((15 - y) / 16); }
    static std::size_t cell(int column_x, int y, int column_z) {
        return static_cast<std::size_t>(column_x + 16 * column_z + 256 * (y & 15));
    }
};

/// Which generation of the format a chunk is written in.
enum class Made { kColumns, kNumeric, kStraddling, kPadded, kFlat };

inline std::int64_t to_data_version(Made made) {
    return made == Made::kStraddling ? 1631
           : made == Made::kPadded   ? 2586
           : made == Made::kFlat     ? 2975
                                     : 1343;
}

inline std::uint8_t two_nibbles(int low, int high) {
    return static_cast<std::uint8_t>((low & 15) | high << 4);
}

/// Indices packed as a generation packs them. @param bits 0 = as many as `kinds` kinds need
inline std::vector<std::uint64_t> packed_indices(const MadeSection& cells, int kinds, bool padded,
                                                 unsigned bits = 0) {
    if (bits == 0)
        for (bits = 4; (1 << bits) < kinds;)
            ++bits;
    std::vector<std::uint64_t> out;
    if (padded) {
        const std::size_t each = 64 / bits;
        out.resize((4096 + each - 1) / each);
        for (std::size_t i = 0; i < 4096; ++i)
            out[i / each] |= std::uint64_t{cells[i]} << (bits * (i % each));
        return out;
    }
    out.resize(64 * bits);
    for (std::size_t i = 0; i < 4096; ++i)
        for (unsigned b = 0; b < bits; ++b)
            if ((cells[i] >> b & 1) != 0)
                out[(i * bits + b) / 64] |= std::uint64_t{1} << ((i * bits + b) % 64);
    return out;
}

inline void write_palette(NbtWriter& out, const char* name) {
    out.list(name, 10, kMadeBlocks.size());
    for (const MadeBlock& block : kMadeBlocks)
        out.string("Name", block.name).end();
}

inline void write_numeric(NbtWriter& out, const MadeSection& cells) {
    Bytes blocks(4096), data(2048, 0), add(2048, 0);
    for (std::size_t i = 0; i < 4096; ++i)
        blocks[i] = static_cast<std::uint8_t>(kMadeBlocks[cells[i]].id);
    out.byte_array("Blocks", blocks).byte_array("Data", data).byte_array("Add", add);
}

inline void write_section(NbtWriter& out, int y, const MadeSection& cells, Made made) {
    out.number8("Y", y);
    const int kinds = static_cast<int>(kMadeBlocks.size());
    if (made == Made::kNumeric) {
        write_numeric(out, cells);
    } else if (made == Made::kFlat) {
        out.compound("block_states");
        write_palette(out, "palette");
        out.long_array("data", packed_indices(cells, kinds, true)).end();
    } else {
        write_palette(out, "Palette");
        out.long_array("BlockStates", packed_indices(cells, kinds, made == Made::kPadded));
    }
    out.end();
}

/// Blocks of a chunk in columns of 128; y outside is lost.
inline void write_columns(NbtWriter& out, const MadeChunk& chunk) {
    Bytes blocks(32768), data(16384, 0);
    for (int x = 0; x < 16; ++x)
        for (int z = 0; z < 16; ++z)
            for (int y = 0; y < 128; ++y)
                blocks[static_cast<std::size_t>((x * 16 + z) * 128 + y)] =
                    static_cast<std::uint8_t>(kMadeBlocks[chunk.at(x, y, z)].id);
    out.byte_array("Blocks", blocks).byte_array("Data", data);
}

inline Bytes chunk_nbt(const MadeChunk& chunk, Made made) {
    NbtWriter out;
    out.compound("");
    const bool level = made != Made::kFlat;
    if (made != Made::kColumns)
        out.number32("DataVersion", to_data_version(made));
    if (level)
        out.compound("Level");
    out.number32("xPos", chunk.x).number32("zPos", chunk.z);
    if (made == Made::kStraddling || made == Made::kPadded || made == Made::kFlat)
        out.string("Status", chunk.status);
    if (made == Made::kColumns) {
        write_columns(out, chunk);
    } else {
        out.list(level ? "Sections" : "sections", 10,
                 static_cast<std::uint32_t>(chunk.sections.size()));
        for (const auto& [y, cells] : chunk.sections)
            write_section(out, y, cells, made);
    }
    if (level)
        out.end();
    return out.end().bytes;
}

}  // namespace terravox::test
