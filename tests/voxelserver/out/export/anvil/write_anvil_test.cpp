#include "voxelserver/out/export/anvil/write_anvil.hpp"

#include <fstream>
#include <nlohmann/json.hpp>

#include "common/util/error.hpp"
#include "common/voxel/side_car.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/out/export/anvil/anvil_reading.hpp"
#include "tests/voxelserver/out/export/shape/painted_world.hpp"

using namespace terravox;
namespace fs = std::filesystem;
using namespace terravox::exports;
using terravox::voxel::Material;

namespace {

const fs::path kBlocks = fs::path(TERRAVOX_SOURCE_DIR) / "config/blocks";
using test::PaintedWorld;
using test::TemporaryFolder;
constexpr std::uint32_t kColours = 1000;

/// A number for a place, without pattern. Ref: Steele, Lea & Flood, SplitMix.
std::uint64_t compute_hash(unsigned seed, int x, int y, int z) {
    std::uint64_t h = seed * 0x9e3779b97f4a7c15ull +
                      static_cast<std::uint32_t>(x) * 0xbf58476d1ce4e5b9ull +
                      static_cast<std::uint32_t>(y) * 0x94d049bb133111ebull +
                      static_cast<std::uint32_t>(z) * 0xd6e8feb86659fd93ull;
    h = (h ^ h >> 30) * 0xbf58476d1ce4e5b9ull;
    h = (h ^ h >> 27) * 0x94d049bb133111ebull;
    return h ^ h >> 31;
}

/// Clumps of all materials, thin air, solid rock, and stretches without anything.
void fill(PaintedWorld& world, unsigned seed) {
    world.fill_with([&](int x, int y, int z) {
        const auto kind = compute_hash(seed, x >> 4, y >> 4, z >> 4) % 5;
        if (kind == 0)
            return Material::kAir;
        if (kind == 1)
            return Material::kRock;
        const auto pick = compute_hash(seed + 1, x >> 1, y >> 1, z >> 1);
        return kind == 2 || pick % 3 == 0 ? static_cast<Material>(pick / 7 % voxel::kMaterialCount)
                                          : Material::kAir;
    });
}

struct Converting {
    voxel::Palette palette =
        voxel::load_palette(fs::path(TERRAVOX_SOURCE_DIR) / "config/materials.toml");
    Meter meter{"test", 1, true};
    Job job;
    Converting(voxel::World& world, const voxel::VoxelBounds& bounds, const fs::path& out,
               int threads = 2, Colours colours = Colours::kTrue)
        : job(world, Part{0, bounds}, out, palette, meter) {
        job.threads = threads;
        job.colours = colours;
    }
    void run() { exports::anvil::write_anvil(job, {kBlocks, ""}); }
};

test::Nbt find_level(const fs::path& folder) {
    return test::NbtParser(test::inflate(test::read_content(folder / "level.dat"), true))
        .root()
        .at("Data");
}

std::map<std::string, std::string> list_files(const fs::path& folder) {
    std::map<std::string, std::string> out;
    for (const auto& file : fs::recursive_directory_iterator(folder))
        if (file.is_regular_file())
            out[fs::relative(file.path(), folder)] = test::read_content(file.path());
    return out;
}

}  // namespace

TEST_CASE(
    "a part that is written as an Anvil world reads back as the same materials, voxel by voxel",
    "[convert][anvil]") {
    const auto seed = GENERATE(1u, 2u, 4u);
    const auto colours = seed % 2 == 0 ? Colours::kMaterial : Colours::kTrue;
    INFO("seed " << seed);
    // Parts that begin and end anywhere, across regions, far from the origin.
    const int x0 = seed == 1 ? -40 : seed == 2 ? 70'000'003 : 500;
    const int y0 = seed == 1 ? -77 : seed == 4 ? 1000 : 5;
    const int z0 = seed == 1 ? -300'007 : 20;
    const std::array<int, 3> min{x0, y0, z0};
    const std::array<int, 3> max{x0 + 60, y0 + 300, z0 + 50};
    PaintedWorld world(min, max, kColours);
    fill(world, seed);
    const voxel::VoxelBounds part{{x0 + 3, y0 + 2, z0}, {x0 + 59, y0 + 291, z0 + 46}};
    const TemporaryFolder folder;
    Converting converting(world, part, folder.path(), 2, colours);
    converting.run();

    const auto read = test::read_world(folder.path());
    const auto car =
        voxel::side_car_from_json(test::read_content(folder.path() / "terravox.json"), "car");
    CHECK(car.offset[0] % 512 == 0);
    CHECK(car.offset[1] % 16 == 0);
    CHECK(car.offset[2] % 512 == 0);
    std::size_t solid = 0;
    int wrong = 0;
    for (int y = min[1]; y < max[1]; ++y)
        for (int z = min[2]; z < max[2]; ++z)
            for (int x = min[0]; x < max[0]; ++x) {
                const auto block =
                    read.blocks.find({x - car.offset[0], y - car.offset[1], z - car.offset[2]});
                const Material meant =
                    block == read.blocks.end() ? Material::kAir : car.blocks.at(block->second.name);
                // A box knows what is hidden as rock.
                const Material expected = !converting.job.part.holds(x, y, z) ? Material::kAir
                                          : world.hidden(x, y, z)             ? Material::kRock
                                                                              : world.at(x, y, z);
                solid += expected != Material::kAir;
                if (meant != expected && ++wrong < 5) {
                    INFO(x << " " << y << " " << z);
                    CHECK(voxel::material_name(meant) == voxel::material_name(expected));
                }
            }
    CHECK(wrong == 0);
    CHECK(solid > 50'000);
    CHECK(read.blocks.size() == solid);
    CHECK(converting.job.voxels() == solid);
    CHECK(converting.job.holes().empty());
    CHECK_FALSE(fs::exists(folder.path() / "conversion.journal"));
}

TEST_CASE("chunks contain what the game needs, and no more", "[convert][anvil]") {
    PaintedWorld world({0, 0, 0}, {40, 60, 40}, kColours);
    world.fill({0, 0, 0}, {40, 30, 40}, Material::kRock);
    world.fill({0, 30, 0}, {40, 31, 40}, Material::kGrass);
    world.fill({5, 31, 5}, {6, 32, 6}, Material::kLowVegetation);   // rooted
    world.fill({7, 31, 5}, {8, 33, 6}, Material::kLowVegetation);   // two high: a bush
    world.fill({9, 30, 5}, {10, 32, 6}, Material::kLowVegetation);  // on rock
    world.fill({16, 30, 0}, {32, 31, 16}, Material::kWater);
    world.fill({0, 31, 16}, {16, 40, 32}, Material::kHighVegetation);
    world.fill({16, 31, 16}, {32, 32, 32}, Material::kSnow);
    world.fill({32, 31, 0}, {40, 32, 16}, Material::kSand);
    const TemporaryFolder folder;
    Converting converting(world, {{0, 0, 0}, {40, 41, 40}}, folder.path(), 1, Colours::kMaterial);
    converting.run();
    const auto read = test::read_world(folder.path());
    CHECK(read.chunks.size() == 9);
    for (const auto& chunk : read.chunks) {
        CHECK(chunk.at("DataVersion").number() == 3955);
        CHECK(chunk.at("Status").text() == "minecraft:full");
        CHECK(chunk.at("isLightOn").number() == 0);
        CHECK(chunk.at("yPos").number() == -4);
        CHECK(chunk.at("sections").list().size() == 24);
        for (const auto& section : chunk.at("sections").list()) {
            CHECK_FALSE(section.has("BlockLight"));
            CHECK_FALSE(section.has("SkyLight"));
        }
    }
    const std::map<std::array<int, 3>, std::string> names{
        {{5, 31, 5}, "short_grass"},     {{7, 31, 5}, "mangrove_leaves"},
        {{7, 32, 5}, "mangrove_leaves"}, {{9, 30, 5}, "mangrove_leaves"},
        {{9, 31, 5}, "mangrove_leaves"}, {{3, 10, 3}, "stone"}};
    for (const auto& [place, name] : names)
        CHECK(read.blocks.at(place).name == "minecraft:" + name);
    CHECK_FALSE(read.blocks.contains({3, 31, 3}));
    const auto& leaves = read.blocks.at({3, 35, 20});
    CHECK(leaves.name == "minecraft:oak_leaves");
    CHECK(leaves.properties ==
          std::map<std::string, std::string>{{"persistent", "true"}, {"distance", "7"}});
    CHECK(read.biomes.at({0, 0, 0}) == "minecraft:plains");
    CHECK(read.biomes.at({5, 7, 1}) == "minecraft:river");
    CHECK(read.biomes.at({1, 70, 5}) == "minecraft:forest");
    CHECK(read.biomes.at({5, -16, 5}) == "minecraft:snowy_plains");
    CHECK(read.biomes.at({9, 3, 1}) == "minecraft:desert");
    CHECK(read.biomes.at({10, 3, 1}) == "minecraft:the_void");

    const auto data = find_level(folder.path());
    CHECK(data.at("LevelName").text() == "an array");
    CHECK(data.at("DataVersion").number() == 3955);
    CHECK(data.at("Version").at("Name").text() == "1.21.1");
    CHECK(data.at("GameType").number() == 1);
    CHECK(data.at("allowCommands").number() == 1);
    CHECK(data.at("SpawnX").number() == 20);
    CHECK(data.at("SpawnY").number() == 32);
    CHECK(data.at("SpawnZ").number() == 20);
    const auto& overworld = data.at("WorldGenSettings").at("dimensions").at("minecraft:overworld");
    const auto& settings = overworld.at("generator").at("settings");
    CHECK(settings.at("biome").text() == "minecraft:the_void");
    CHECK(settings.at("layers").list().empty());
    CHECK(data.at("DataPacks").at("Enabled").list().size() == 1);
    CHECK_FALSE(fs::exists(folder.path() / "datapacks"));
    CHECK(list_files(folder.path()).size() == 3);
    CHECK(converting.job.files().size() == 3);
}

TEST_CASE("bytes are the same for any number of threads, and after being cut off",
          "[convert][anvil][all]") {
    PaintedWorld world({-600, 0, -100}, {600, 40, 100}, kColours);
    fill(world, 9);
    const voxel::VoxelBounds part{{-600, 0, -100}, {600, 40, 100}};
    const TemporaryFolder one;
    const TemporaryFolder four;
    const TemporaryFolder cut;
    Converting(world, part, one.path(), 1).run();
    Converting(world, part, four.path(), 4).run();
    const auto expected = list_files(one.path());
    CHECK(expected.size() > 5);
    CHECK(list_files(four.path()) == expected);

    // One thread, so that regions are made in order; what cuts it off is no Error, which would be a
    // hole.
    const voxel::BoxKey late{0, 5, 0, 0};
    world.make_hole(late, [] { throw std::runtime_error("cut off"); });
    CHECK_THROWS_WITH(Converting(world, part, cut.path(), 1).run(), test::contains("cut off"));
    CHECK_FALSE(fs::exists(cut.path() / "level.dat"));
    const auto done = list_files(cut.path()).size();
    CHECK(done > 1);
    CHECK(done < expected.size());
    world.mend_hole(late);
    const int before = world.requests();
    Converting again(world, part, cut.path(), 2);
    again.run();
    const int boxes_again = world.requests() - before;
    const TemporaryFolder whole;
    Converting first(world, part, whole.path(), 2);
    first.run();
    CHECK(boxes_again < world.requests() - before - boxes_again);
    CHECK(list_files(cut.path()) == expected);
    CHECK(again.job.voxels() == first.job.voxels());
    CHECK(again.job.files().size() == first.job.files().size());
    // Another part in the same folder would mix two worlds.
    CHECK_THROWS_WITH(Converting(world, {{-600, 0, -100}, {600, 39, 100}}, cut.path()).run(),
                      test::contains("holds a world"));
    fs::remove(cut.path() / "level.dat");
    CHECK_THROWS_WITH(Converting(world, {{-600, 0, -100}, {600, 39, 100}}, cut.path()).run(),
                      test::contains("regions of another world"));
    CHECK_THROWS_WITH(Converting(world, part, cut.path() / "terravox.json").run(),
                      test::contains("is a file"));
}

TEST_CASE("a folder with other files is left alone", "[convert][anvil]") {
    PaintedWorld world({0, 0, 0}, {64, 20, 64}, kColours);
    world.fill({0, 0, 0}, {64, 20, 64}, Material::kGrass);
    const voxel::VoxelBounds part{{0, 0, 0}, {64, 20, 64}};
    for (const char* name : {"notes.txt", ".hidden", "terravox.json", "datapacks"}) {
        const TemporaryFolder folder;
        std::ofstream(folder.path() / name) << "mine";
        const auto before = list_files(folder.path());
        CHECK_THROWS_WITH(Converting(world, part, folder.path()).run(),
                          test::contains(std::string("holds ") + name));
        CHECK(list_files(folder.path()) == before);
    }
    // Cut off before the first region, by a conversion of other data.
    const TemporaryFolder folder;
    std::ofstream(folder.path() / exports::anvil::kWorldJournal) << "another one\n";
    fs::create_directory(folder.path() / "region");
    CHECK_NOTHROW(Converting(world, part, folder.path()).run());
}

TEST_CASE("a world has the title that was given, its own, or the name of its folder",
          "[convert][anvil]") {
    PaintedWorld world({0, 0, 0}, {64, 20, 64}, kColours);
    world.fill({0, 0, 0}, {64, 20, 64}, Material::kGrass);
    struct Case {
        const char* given;
        const char* own;
        const char* expected;
    };
    const auto c = GENERATE(values<Case>({
        {"Bled", "generated 7", "Bled"},
        {"", "generated 7", "generated 7"},
        {"", "", "my valley"},
    }));
    world.editable_info().title = c.own;
    const TemporaryFolder folder;
    Converting converting(world, {{0, 0, 0}, {64, 20, 64}}, folder.path() / "my valley");
    exports::anvil::write_anvil(converting.job, {kBlocks, c.given});
    CHECK(find_level(folder.path() / "my valley").at("LevelName").text() == c.expected);
}

TEST_CASE("a world whose bounds are higher than what stands there needs no data pack",
          "[convert][anvil]") {
    PaintedWorld world({0, 400, 0}, {128, 900, 64}, kColours);
    world.fill({0, 400, 0}, {128, 520, 64}, Material::kRock);
    world.fill({70, 520, 9}, {71, 740, 10}, Material::kWall);
    const TemporaryFolder folder;
    Converting(world, {{0, 400, 0}, {128, 900, 64}}, folder.path()).run();
    CHECK_FALSE(fs::exists(folder.path() / "datapacks"));
    CHECK(test::read_world(folder.path()).blocks.size() == 128u * 64 * 120 + 220);
}

TEST_CASE("a high world has a data pack that is switched on", "[convert][anvil]") {
    PaintedWorld world({0, 100, 0}, {20, 900, 20}, kColours);
    world.fill({0, 100, 0}, {20, 900, 20}, Material::kRock);
    const TemporaryFolder folder;
    Converting(world, {{0, 100, 0}, {20, 900, 20}}, folder.path()).run();
    const auto data = find_level(folder.path());
    CHECK(data.at("DataPacks").at("Enabled").list().at(1).text() == "file/terravox-height");
    CHECK(data.at("SpawnY").number() == 900);
    const fs::path pack = folder.path() / "datapacks/terravox-height";
    for (const char* games : {"to_1_21_10", "from_1_21_11", "from_26_1"}) {
        const auto type = nlohmann::json::parse(
            test::read_content(pack / games / "data/minecraft/dimension_type/overworld.json"));
        CHECK(type["min_y"] == 96);
        CHECK(type["height"] == 880);
    }
    CHECK(nlohmann::json::parse(test::read_content(pack / "pack.mcmeta"))["pack"]["pack_format"] ==
          48);
    const auto read = test::read_world(folder.path());
    CHECK(read.blocks.size() == 20u * 20 * 800);
    CHECK(read.chunks.at(0).at("yPos").number() == 6);
    CHECK(read.chunks.at(0).at("sections").list().size() == 55);
}
