#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/out/export/anvil/anvil_reading.hpp"
#include "voxelserver/out/export/anvil/export_blocks.hpp"
#include "voxelserver/out/export/anvil/nbt_writer.hpp"
#include "voxelserver/out/export/anvil/region_writer.hpp"
#include "voxelserver/out/export/anvil/section.hpp"
#include "voxelserver/out/export/anvil/write_anvil.hpp"

// What a world for Minecraft is put together from: where it lies, region files, blocks, texts.

using namespace terravox;
using namespace terravox::exports;
using terravox::test::TemporaryFolder;
using terravox::voxel::Material;

namespace {
const std::filesystem::path kBlocks = std::filesystem::path(TERRAVOX_SOURCE_DIR) / "config/blocks";
}

TEST_CASE(
    "heights stay where they are when they fit, move when they do not, and need a data pack when "
    "they are too many",
    "[convert][anvil]") {
    struct Case {
        const char* name;
        int low;
        int end;
        int offset_y;
        int min_y;
        int height;
    };
    const auto c = GENERATE(values<Case>({
        {"usual", 0, 100, 0, -64, 384},
        {"all of the usual", -64, 320, 0, -64, 384},
        {"a layer too low", -65, 200, -16, -64, 384},
        {"a town in the hills", 290, 420, 352, -64, 384},
        {"high up", 2000, 2300, 2064, -64, 384},
        {"384 that begin where a section does not", 300, 684, 0, 288, 464},
        {"a mountain", 200, 900, 0, 192, 784},
        {"a high mountain", 800, 2900, 2832, -2032, 2176},
        {"from the deep", -2500, -100, -480, -2032, 2480},
        {"all there is", -2032, 2032, 0, -2032, 4064},
        {"all there is, elsewhere", 16, 4080, 2048, -2032, 4064},
    }));
    DYNAMIC_SECTION(c.name) {
        const anvil::Place place = anvil::find_place({0, {{-10, c.low, -10}, {10, c.end, 10}}});
        CHECK(place.offset == std::array<int, 3>{0, c.offset_y, 0});
        CHECK(place.min_y == c.min_y);
        CHECK(place.height == c.height);
        CHECK(place.needs_pack() == (c.min_y != -64 || c.height != 384));
        CHECK(c.low - place.offset[1] >= place.min_y);
        CHECK(c.end - place.offset[1] <= place.min_y + place.height);
    }
}

TEST_CASE("parts that no world of Minecraft holds are refused, and a level that fits is named",
          "[convert][anvil]") {
    struct Case {
        const char* name;
        Part part;
        const char* says;
    };
    const auto c = GENERATE(values<Case>({
        {"high",
         {0, {{0, 0, 0}, {1, 4065, 1}}},
         "4065 voxels high; allowed: up to 4064 blocks, that is --level 1 "},
        {"very high",
         {2, {{0, -9000, 0}, {1, 9000, 1}}},
         "18000 voxels high; allowed: up to 4064 blocks, that is --level 5 "},
        {"wide",
         {0, {{-40'000'000, 0, 0}, {40'000'000, 1, 1}}},
         "80000000 voxels wide; allowed: up to 59996976 blocks, that is --level 1 "},
    }));
    DYNAMIC_SECTION(c.name) {
        CHECK_THROWS_WITH(anvil::find_place(c.part), test::contains(c.says));
    }
}

TEST_CASE("chunks that a region cannot hold lie next to it", "[convert][anvil]") {
    const TemporaryFolder folder;
    std::mt19937 random(3);
    std::map<int, std::string> chunks;
    std::vector<anvil::PackedChunk> packed;
    // By length: just one sector, just more, 255 sectors, just more, far more; negative places.
    int i = 0;
    for (const std::size_t length :
         {1ul, 4091ul, 4092ul, 255ul * 4096 - 5, 255ul * 4096 - 4, 3'000'000ul}) {
        std::string bytes(length, '\0');
        for (char& c : bytes)
            c = static_cast<char>(random());
        const int slot = i++ * 171;
        chunks[slot] = bytes;
        packed.push_back({-64 + slot % 32, 32 + slot / 32, bytes});
    }
    std::shuffle(packed.begin(), packed.end(), random);
    const auto written = anvil::write_region(folder.path(), -2, 1, packed);
    CHECK(test::packed_chunks(folder.path() / "r.-2.1.mca") == chunks);
    std::uint64_t on_disk = 0;
    int beside = 0;
    for (const auto& file : std::filesystem::directory_iterator(folder.path())) {
        on_disk += file.file_size();
        beside += file.path().extension() == ".mcc";
    }
    CHECK(beside == 2);
    CHECK(written == on_disk);
}

TEST_CASE("a block of the export stands for one material, and colours choose the nearest",
          "[convert][anvil]") {
    const auto table = minecraft::BlockTable::load(kBlocks);
    const auto blocks = anvil::ExportBlocks::load(kBlocks, table);
    std::map<std::string, Material> meanings;
    for (const auto& block : blocks.all()) {
        INFO(block.name);
        CHECK(meanings.emplace(block.name, block.material).first->second == block.material);
        CHECK(table.of(block.name, {}).known);
    }
    CHECK(blocks.meanings() == meanings);
    for (int i = 1; i < voxel::kMaterialCount; ++i) {
        const auto material = static_cast<Material>(i);
        CHECK(blocks.all()[blocks.plain(material)].material == material);
        CHECK(blocks.all()[blocks.rooted(material)].material == material);
        for (const voxel::Rgb8 colour :
             {voxel::Rgb8{0, 0, 0}, voxel::Rgb8{255, 255, 255}, voxel::Rgb8{200, 30, 20}})
            CHECK(blocks.all()[blocks.painted(material, colour)].material == material);
    }
    const auto painted = [&](Material m, voxel::Rgb8 c) {
        return blocks.all()[blocks.painted(m, c)].name;
    };
    CHECK(painted(Material::kPlain, {170, 40, 30}) == "minecraft:red_wool");
    CHECK(painted(Material::kObject, {50, 50, 160}) == "minecraft:blue_concrete");
    CHECK(painted(Material::kRoad, {20, 20, 25}) == "minecraft:black_concrete");
    CHECK(painted(Material::kGrass, {170, 40, 30}) == "minecraft:grass_block");
    // A block's own colour is nearest to itself.
    for (const auto& block : blocks.all())
        if (block.material == Material::kPlain || block.material == Material::kWood)
            CHECK(painted(block.material, block.colour) == block.name);
}

TEST_CASE("a material that the table of blocks to export leaves out becomes its own block",
          "[convert][anvil]") {
    const auto table = minecraft::BlockTable::load(kBlocks);
    const TemporaryFolder folder;
    std::ofstream(folder.path() / "export.toml") << "[rock]\nblock = \"granite\"\n";
    const auto blocks = anvil::ExportBlocks::load(folder.path(), table);
    const auto to_name = [&](Material m) { return blocks.all()[blocks.plain(m)].name; };
    CHECK(to_name(Material::kRock) == "minecraft:granite");
    CHECK(to_name(Material::kTower) == "minecraft:iron_block");
    CHECK(to_name(Material::kWater) == "minecraft:water");
}

TEST_CASE("bad tables of blocks to export are refused", "[convert][anvil]") {
    const auto table = minecraft::BlockTable::load(kBlocks);
    const std::string shipped = test::read_content(kBlocks / "export.toml");
    struct Case {
        const char* name;
        std::string from;
        std::string to;
        const char* says;
    };
    const auto c = GENERATE_COPY(values<Case>({
        {"two materials", "[rock]", "[rock]\nblock = \"coarse_dirt\"",
         "'coarse_dirt' stands for both"},
        {"no block", "[rock]", "[rock]\nblock = \"stoone\"",
         "[rock] 'stoone' is no block of blocks.toml"},
        {"one that the game turns into air", "[rock]",
         "[tower]\nblock = \"torch[lit=false]\"\n[rock]", ""},
        {"air by name", "[rock]", "[tower]\nblock = \"stone_button\"\n[rock]",
         "[tower] 'stone_button' is air"},
        {"no such material", "[rock]", "[rocks]", "'rocks' is no material"},
        {"other field", "rooted =", "rooting =",
         "[low_vegetation] rooting is no field; allowed: block, paint, rooted"},
        {"number", "[rock]", "[rock]\nblock = 3", "[rock] holds what is no block"},
        {"open", "distance=7", "distance=7|6", "leaves distance open"},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        std::string text = shipped;
        const auto at = text.find(c.from);
        REQUIRE(at != std::string::npos);
        std::ofstream(folder.path() / "export.toml") << text.replace(at, c.from.size(), c.to);
        if (*c.says == 0)
            CHECK_NOTHROW(anvil::ExportBlocks::load(folder.path(), table));
        else
            CHECK_THROWS_WITH(anvil::ExportBlocks::load(folder.path(), table),
                              test::contains(c.says));
    }
}

TEST_CASE("each version of the game finds in the data pack what it requires of the overworld",
          "[convert][anvil]") {
    struct Case {
        const char* game;
        int format;  // of its data packs
        std::vector<const char*> required;
        std::vector<const char*> unknown;  // attributes, which are refused
    };
    const auto c = GENERATE(values<Case>({
        {"1.21.1", 48, {"ultrawarm", "natural", "effects", "bed_works", "has_raids"}, {}},
        {"1.21.8", 81, {"ultrawarm", "natural", "effects", "bed_works", "has_raids"}, {}},
        {"1.21.10", 88, {"ultrawarm", "natural", "effects", "bed_works", "has_raids"}, {}},
        {"1.21.11", 94, {"attributes", "timelines"}, {"minecraft:visual/ambient_light_color"}},
        {"26.1", 101, {"attributes", "timelines", "default_clock", "has_ender_dragon_fight"}, {}},
        {"26.2", 107, {"attributes", "timelines", "default_clock", "has_ender_dragon_fight"}, {}},
        {"later", 300, {"attributes", "timelines", "default_clock", "has_ender_dragon_fight"}, {}},
    }));
    DYNAMIC_SECTION(c.game) {
        const auto pack = anvil::height_pack({{}, -64, 1024});
        const auto about = nlohmann::json::parse(pack.at("pack.mcmeta"));
        // Before format 82 the old fields are read, later the new ones; a pack for both has both,
        // with the same bounds.
        const auto bounds = [&](const nlohmann::json& entry, const char* old) {
            const auto as_old = entry.at(old).get<std::array<int, 2>>();
            const std::array<int, 2> as_new{entry.at("min_format"), entry.at("max_format")};
            CHECK(as_old[0] == as_new[0]);
            CHECK((as_old[1] == as_new[1] || as_old[1] == 81));
            return c.format <= 81 ? as_old : as_new;
        };
        const auto holds = [&](const std::array<int, 2>& range) {
            return c.format >= range[0] && c.format <= range[1];
        };
        CHECK(holds(bounds(about["pack"], "supported_formats")));
        std::vector<std::string> taken;
        for (const auto& entry : about["overlays"]["entries"])
            if (holds(bounds(entry, "formats")))
                taken.push_back(entry["directory"]);
        REQUIRE(taken.size() == 1);
        const auto type = nlohmann::json::parse(
            pack.at(taken.front() + "/data/minecraft/dimension_type/overworld.json"));
        for (const char* field : c.required)
            CHECK(type.contains(field));
        CHECK(type["height"] == 1024);
        CHECK(type["logical_height"] == 1024);
        for (const char* attribute : c.unknown)
            CHECK_FALSE(type["attributes"].contains(attribute));
    }
}

TEST_CASE("titles are written as Java reads them", "[convert][anvil]") {
    CHECK(anvil::java_utf8("Grad Ptuj \xc4\x8d") == "Grad Ptuj \xc4\x8d");
    CHECK(anvil::java_utf8(std::string("a\0b", 3)) ==
          "a\xc0\x80"
          "b");
    CHECK(anvil::java_utf8("\xf0\x9f\x8f\xb0") == "\xed\xa0\xbc\xed\xbf\xb0");
    CHECK(anvil::java_utf8("x\xff\xc4") == "x??");
    CHECK(anvil::java_utf8(std::string(70'000, 'a')).size() == 65'535);
}
