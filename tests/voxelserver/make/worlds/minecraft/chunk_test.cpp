#include "voxelserver/make/worlds/minecraft/chunk.hpp"

#include <algorithm>
#include <random>

#include "tests/catch.hpp"
#include "tests/voxelserver/make/worlds/minecraft/made_chunk.hpp"
#include "voxelserver/make/worlds/minecraft/block_appearance_cache.hpp"

namespace terravox::minecraft {
namespace {

using test::Bytes;
using test::Made;
using test::MadeChunk;
using test::NbtWriter;

MadeChunk random_chunk(std::mt19937_64& random, int first_y, int last_y) {
    MadeChunk chunk;
    chunk.x = -3;
    chunk.z = 7;
    for (int y = first_y; y <= last_y; ++y)
        for (auto& cell : chunk.sections[y])
            cell = static_cast<std::uint16_t>(random() % test::kMadeBlocks.size());
    return chunk;
}

// The made block at a place of what was decoded: by its number or its name.
std::uint16_t block_at(const ChunkBlocks& blocks, int x, int y, int z) {
    for (const ChunkSection& section : blocks.sections()) {
        if (section.y != (y >= 0 ? y / 16 : -((15 - y) / 16)))
            continue;
        const std::uint16_t cell =
            section
                .cells[section.uniform ? 0 : static_cast<std::size_t>(x + 16 * z + 256 * (y & 15))];
        PaletteName name;
        if (!section.numeric)
            palette_name(blocks.palette[section.palette_begin + cell], name);
        for (std::size_t i = 0; i < test::kMadeBlocks.size(); ++i)
            if (section.numeric ? test::kMadeBlocks[i].id * 16 == cell
                                : name.name == test::kMadeBlocks[i].name)
                return static_cast<std::uint16_t>(i);
        return 999;
    }
    return 0;
}

TEST_CASE("chunks of every generation give back each block where it was put",
          "[raytracer][minecraft]") {
    struct Case {
        const char* name;
        Made made;
        int first_y;
        int last_y;
    };
    const auto c = GENERATE(values<Case>({{"columns of 128", Made::kColumns, 0, 7},
                                          {"numeric ids in sections", Made::kNumeric, 0, 15},
                                          {"indices across longs", Made::kStraddling, 0, 15},
                                          {"padded indices", Made::kPadded, 0, 15},
                                          {"without Level, below zero", Made::kFlat, -4, 19}}));
    std::mt19937_64 random(5);
    const MadeChunk chunk = random_chunk(random, c.first_y, c.last_y);
    const Bytes nbt = test::chunk_nbt(chunk, c.made);
    ChunkBlocks blocks;
    for (int pass = 0; pass < 2; ++pass) {  // the second into memory that was used before
        decode_chunk(nbt, blocks);
        CHECK(blocks.place == ChunkPlace{-3, 7});
        CHECK(blocks.finished);
        CHECK(blocks.oddities.empty());
        int wrong = 0;
        for (int y = c.first_y * 16 - 16; y < c.last_y * 16 + 32; ++y)
            for (int z = 0; z < 16; ++z)
                for (int x = 0; x < 16; ++x)
                    wrong += block_at(blocks, x, y, z) != chunk.at(x, y, z) ? 1 : 0;
        INFO(c.name);
        CHECK(wrong == 0);
    }
}

TEST_CASE("palettes of every size are unpacked", "[raytracer][minecraft]") {
    const bool padded = GENERATE(true, false);
    for (const int kinds : {2, 16, 17, 32, 33, 100, 256, 257, 700, 1100, 2049, 4096}) {
        std::mt19937_64 random(static_cast<std::uint64_t>(kinds));
        test::MadeSection cells;
        for (auto& cell : cells)
            cell = static_cast<std::uint16_t>(random() % static_cast<unsigned>(kinds));
        NbtWriter out;
        out.chunk(padded ? 3000 : 1600, 1)
            .number8("Y", 0)
            .list("Palette", 10, static_cast<std::uint32_t>(kinds));
        for (int i = 0; i < kinds; ++i)
            out.string("Name", "b" + std::to_string(i)).end();
        out.long_array("BlockStates", test::packed_indices(cells, kinds, padded)).end().end();
        ChunkBlocks blocks;
        decode_chunk(out.bytes, blocks);
        INFO(kinds << (padded ? " padded" : " across longs"));
        REQUIRE(blocks.sections().size() == 1);
        CHECK(std::equal(cells.begin(), cells.end(), blocks.sections()[0].cells.begin()));
    }
}

TEST_CASE("indices of more bits than the palette needs are read by the array's length",
          "[raytracer][minecraft]") {
    struct Case {
        std::optional<std::int64_t> data_version;
        bool padded;
        unsigned bits;
    };
    const auto c = GENERATE(values<Case>({{2586, true, 5},
                                          {2586, true, 6},
                                          {2586, true, 12},
                                          {2586, true, 16},
                                          {2730, true, 8},
                                          {2529, true, 7},
                                          {std::nullopt, true, 5},
                                          {2230, false, 5},
                                          {1631, false, 14},
                                          {std::nullopt, false, 5}}));
    test::MadeSection cells;
    std::mt19937_64 random(c.bits);
    for (auto& cell : cells)
        cell = static_cast<std::uint16_t>(random() % 9);
    std::vector<std::uint8_t> bytes;
    for (const std::uint64_t word : test::packed_indices(cells, 9, c.padded, c.bits))
        for (int shift = 56; shift >= 0; shift -= 8)
            bytes.push_back(static_cast<std::uint8_t>(word >> shift));
    ChunkSection section{};
    unpack_cells({bytes.data(), bytes.size() / 8}, 9, c.data_version, section);
    INFO(c.data_version.value_or(0) << ", " << c.bits << " bits");
    CHECK(std::equal(cells.begin(), cells.end(), section.cells.begin()));
}

TEST_CASE("Add nibbles make ids above 255, and Data their data", "[raytracer][minecraft]") {
    Bytes ids(4096, 0), add(2048, 0), data(2048, 0);
    ids[0] = 0x34;
    ids[1] = 0x35;
    add[0] = test::two_nibbles(0x2, 0xF);
    data[0] = test::two_nibbles(0x9, 0x1);
    NbtWriter out;
    out.compound("").compound("Level").number32("xPos", 0).number32("zPos", 0);
    out.list("Sections", 10, 1).number8("Y", 0).byte_array("Add", add).byte_array("Blocks", ids);
    out.byte_array("Data", data).end().end().end();
    ChunkBlocks blocks;
    decode_chunk(out.bytes, blocks);
    REQUIRE(blocks.sections().size() == 1);
    CHECK(blocks.sections()[0].cells[0] == (0x234 << 4 | 9));
    CHECK(blocks.sections()[0].cells[1] == (0xF35 << 4 | 1));
}

// A chunk of one section whose fields `write` writes.
template <class Write>
Bytes one_section(std::int64_t data_version, const Write& write) {
    NbtWriter out;
    out.chunk(data_version, 1).number8("Y", 0);
    write(out);
    return out.end().end().bytes;
}

TEST_CASE("a chunk whose sections make no sense is an error that says why",
          "[raytracer][minecraft]") {
    const test::MadeSection nines = [] {
        test::MadeSection cells;
        cells.fill(9);  // one past the palette of made blocks
        return cells;
    }();
    // A section of the made palette and these indices.
    const auto indexed = [](std::int64_t data_version, const std::vector<std::uint64_t>& longs) {
        return one_section(data_version, [&](NbtWriter& out) {
            test::write_palette(out, "Palette");
            out.long_array("BlockStates", longs);
        });
    };
    const auto longs = [](std::size_t count) { return std::vector<std::uint64_t>(count); };
    struct Case {
        const char* name;
        Bytes nbt;
        const char* message;
    };
    const std::vector<Case> cases = {
        {"an index past the palette", indexed(3000, test::packed_indices(nines, 9, true)),
         "index 9 into a palette of 9"},
        {"too few longs", indexed(3000, longs(255)), "255 longs"},
        {"longs of another width", indexed(3000, longs(342)), "342 longs"},
        {"longs of no width", indexed(2586, longs(341)), "allowed: 256, or those of more bits"},
        {"fewer bits than needed, in 1.16",
         one_section(2586,
                     [&](NbtWriter& out) {
                         out.list("Palette", 10, 17);
                         for (int i = 0; i < 17; ++i)
                             out.string("Name", "b" + std::to_string(i)).end();
                         out.long_array("BlockStates", longs(256));
                     }),
         "256 longs of indices for a palette of 17 blocks; allowed: 342"},
        {"too few longs, before 1.16", indexed(1631, longs(192)), "192 longs"},
        {"no longs", one_section(3000, [](NbtWriter& out) { test::write_palette(out, "Palette"); }),
         "0 longs"},
        {"an empty palette",
         one_section(3000,
                     [&](NbtWriter& out) {
                         out.list("Palette", 10, 0).long_array("BlockStates", longs(256));
                     }),
         "a palette of 0"},
        {"a palette of strings",
         one_section(3000, [](NbtWriter& out) { out.list("Palette", 8, 1).text("stone"); }),
         "no list of compounds"},
        {"Blocks of another length",
         one_section(1343, [](NbtWriter& out) { out.byte_array("Blocks", Bytes(4095, 1)); }),
         "Blocks of 4095 bytes"},
        {"Data of another length",
         one_section(
             1343,
             [](NbtWriter& out) {
                 out.byte_array("Blocks", Bytes(4096, 1)).byte_array("Data", Bytes(4096, 1));
             }),
         "Data of 4096 bytes"},
        {"columns of another height",
         NbtWriter().compound("").byte_array("Blocks", Bytes(65536, 1)).end().bytes,
         "Blocks of 65536 bytes"},
        {"no chunk at all", NbtWriter().compound("").string("Author", "me").end().bytes,
         "it is no chunk"},
        {"too many sections",
         NbtWriter().compound("").list("sections", 10, 5000).raw(0, 8).raw(0, 5000).end().bytes,
         "5000 sections"},
    };
    ChunkBlocks blocks;
    for (const Case& c : cases)
        DYNAMIC_SECTION(c.name) {
            CHECK_THROWS_WITH(decode_chunk(c.nbt, blocks), test::contains(c.message));
        }
}

TEST_CASE(
    "of two sections at one height the last counts, and those outside the legal heights are left "
    "out and named",
    "[raytracer][minecraft]") {
    NbtWriter out;
    out.chunk(2975, 5);
    for (const auto& [y, block] : {std::pair{3, 1}, std::pair{-4, 2}, std::pair{3, 4},
                                   std::pair{-128, 1}, std::pair{127, 0}}) {
        test::MadeSection cells;
        cells.fill(static_cast<std::uint16_t>(block));
        if (y == 127)  // air at an illegal height is no harm: light is kept there
            out.number8("Y", y)
                .compound("block_states")
                .list("palette", 10, 1)
                .string("Name", "minecraft:air")
                .end()
                .end()
                .end();
        else
            test::write_section(out, y, cells, Made::kFlat);
    }
    ChunkBlocks blocks;
    decode_chunk(out.end().bytes, blocks);
    REQUIRE(blocks.sections().size() == 2);
    CHECK(blocks.sections()[0].y == -4);
    CHECK(block_at(blocks, 5, 50, 5) == 4);
    REQUIRE(blocks.oddities.size() == 2);
    CHECK_THAT(blocks.oddities[0], test::contains("y = -128 is left out"));
    CHECK_THAT(blocks.oddities[1], test::contains("y = 3 is there twice"));
}

TEST_CASE("a chunk is finished unless its status says otherwise", "[raytracer][minecraft]") {
    ChunkBlocks blocks;
    for (const auto& [status, finished] :
         {std::pair{"full", true}, std::pair{"minecraft:full", true},
          std::pair{"postprocessed", true}, std::pair{"", true},
          std::pair{"minecraft:features", false}, std::pair{"empty", false}}) {
        MadeChunk chunk;
        chunk.status = status;
        decode_chunk(test::chunk_nbt(chunk, Made::kFlat), blocks);
        INFO(status);
        CHECK(blocks.finished == finished);
    }
}

}  // namespace
}  // namespace terravox::minecraft
