#include <set>

#include "common/util/error.hpp"
#include "common/voxel/side_car.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/make/worlds/minecraft/made_world.hpp"
#include "voxelserver/make/worlds/minecraft/world_info.hpp"

namespace terravox::minecraft {
namespace {

using test::Bytes;
using test::Made;
using test::MadeWorld;
using test::TemporaryFolder;

std::string base36(int v) {
    const bool negative = v < 0;
    std::string out;
    for (auto left = static_cast<unsigned>(negative ? -v : v); left != 0 || out.empty(); left /= 36)
        out.insert(out.begin(), "0123456789abcdefghijklmnopqrstuvwxyz"[left % 36]);
    return (negative ? "-" : "") + out;
}

// Alpha chunks, in folders of two levels or side by side.
std::map<std::string, Bytes> alpha_files(const MadeWorld& world, bool tree) {
    std::map<std::string, Bytes> out;
    for (const auto& [place, chunk] : world.chunks) {
        const std::string name = "c." + base36(chunk.x) + "." + base36(chunk.z) + ".dat";
        out[tree ? base36(chunk.x & 63) + "/" + base36(chunk.z & 63) + "/" + name : name] =
            test::deflated(test::chunk_nbt(chunk, Made::kColumns), true);
    }
    return out;
}

TEST_CASE("each voxel of a world is the block that was put there, across chunks, regions and boxes",
          "[raytracer][minecraft]") {
    // How chunks of each generation are read is tested with chunks, and side by side below.
    const MadeWorld made = test::random_world(11, -40, 20);
    const TemporaryFolder folder;
    test::write_files(folder.path(), made.files(Made::kFlat));
    test::write_bytes(folder.path() / "level.dat", test::level_dat_nbt("made"));
    const auto world = test::open_made(folder.path());
    CHECK(world->info().title == "made");
    CHECK(world->info().bounds.min[1] == -40);
    CHECK(test::differing_voxels(*world, made) == 0);
    CHECK(world->damage().empty());
}

TEST_CASE("Alpha chunks are read from folders of two levels, and side by side",
          "[raytracer][minecraft]") {
    const bool tree = GENERATE(true, false);
    const MadeWorld made = test::random_world(3, 0, 30);
    const TemporaryFolder folder;
    test::write_files(folder.path(), alpha_files(made, tree));
    const auto world = test::open_made(folder.path());
    INFO((tree ? "folders" : "side by side"));
    CHECK(test::differing_voxels(*world, made) == 0);
    CHECK(describe(folder.path(), "", false, 1).format == "Alpha");
}

TEST_CASE("chunks of different generations stand side by side in one world",
          "[raytracer][minecraft]") {
    const MadeWorld made = test::random_world(8, 0, 40);
    std::map<std::string, test::MadeRegion> regions;
    int next = 0;
    for (const auto& [place, chunk] : made.chunks) {
        const Made generation = std::array{Made::kNumeric, Made::kStraddling, Made::kPadded,
                                           Made::kFlat}[static_cast<std::size_t>(next % 4)];
        const std::string name = "r." + std::to_string(voxel::floor_div(chunk.x, 32)) + "." +
                                 std::to_string(voxel::floor_div(chunk.z, 32)) + ".mca";
        regions[name].put((chunk.x & 31) + 32 * (chunk.z & 31), test::chunk_nbt(chunk, generation),
                          1 + next++ % 4);
    }
    const TemporaryFolder folder;
    for (const auto& [name, region] : regions)
        test::write_bytes(folder.path() / name, region.bytes);  // without a folder `region`
    CHECK(test::differing_voxels(*test::open_made(folder.path()), made) == 0);
    const WorldFacts facts = describe(folder.path(), "", false, 1);
    CHECK(facts.dimensions.at(0).versions.size() == 4);
    CHECK(facts.dimensions.at(0).compressions.size() == 4);
}

TEST_CASE("boxes do not depend on threads, on order, or on how little memory there is",
          "[raytracer][minecraft]") {
    const MadeWorld made = test::random_world(21, -20, 40);
    const TemporaryFolder folder;
    test::write_files(folder.path(), made.files(Made::kFlat));
    const auto one = test::open_made(folder.path(), "overworld", 1);
    const auto other = open_minecraft_world({folder.path(), "overworld", std::size_t{16} << 20, 4},
                                            test::shipped_blocks());
    CHECK(one->info().bounds == other->info().bounds);
    std::vector<voxel::BoxKey> keys;
    for (int level = 0; level < one->info().levels; ++level) {
        const voxel::BoxRange range = voxel::boxes_over(one->info().bounds, level);
        for (int z = range.min.bz; z < range.max.bz; ++z)
            for (int y = range.min.by; y < range.max.by; ++y)
                for (int x = range.min.bx; x < range.max.bx; ++x)
                    keys.push_back({level, x, y, z});
    }
    REQUIRE(keys.size() > 8);
    std::vector<std::uint64_t> sums;
    for (const auto& key : keys)
        sums.push_back(one->box(key) ? one->box(key)->checksum() : 0);
    for (std::size_t i = keys.size(); i-- > 0;)
        CHECK((other->box(keys[i]) ? other->box(keys[i])->checksum() : 0) == sums[i]);
}

TEST_CASE("only columns of boxes with chunks may hold anything", "[raytracer][minecraft]") {
    MadeWorld made;
    made.chunk(0, 0).sections[0].fill(1);
    made.chunk(5000, -3000).sections[0].fill(1);
    const TemporaryFolder folder;
    test::write_files(folder.path(), made.files(Made::kFlat));
    const auto world = test::open_made(folder.path());
    for (int level = 0; level < world->info().levels; ++level) {
        const int columns = static_cast<int>(world->info().bounds.max[0] / (64 << level)) + 1;
        std::set<int> full;
        for (int bx = 0; bx < columns; ++bx)
            for (const int bz : {0, -1, voxel::floor_div(-48000, 64 << level)})
                if (!world->column(level, bx, bz).empty())
                    full.insert(bx);
        INFO("level " << level);
        CHECK(full == std::set<int>{0, 80000 / (64 << level)});
        if (level <= 3)
            CHECK(world->box({level, 80000 / (64 << level), 0,
                              voxel::floor_div(-48000, 64 << level)}) != nullptr);
    }
}

TEST_CASE("of scattered chunks the largest part is framed", "[raytracer][minecraft]") {
    MadeWorld made;
    for (const auto& [x, z] :
         {std::pair{0, 0}, {300, 5}, {307, 5}, {300, 9}, {-200, -200}, {-201, -200}})
        made.chunk(x, z).set(1, 20, 1, 1);
    const TemporaryFolder folder;
    test::write_files(folder.path(), made.files(Made::kFlat));
    const auto world = test::open_made(folder.path());
    CHECK(world->info().bounds ==
          voxel::VoxelBounds{{-201 * 16, 20, -200 * 16}, {308 * 16, 21, 160}});
    CHECK(world->info().framed == voxel::VoxelBounds{{4800, 20, 80}, {308 * 16, 21, 160}});
    CHECK(test::open_made(folder.path() / "region/r.9.0.mca")->info().framed.empty());
}

TEST_CASE(
    "in a world with many chunks some define the heights, and what lies outside is cut off and "
    "named",
    "[raytracer][minecraft]") {
    MadeWorld made;
    for (int x = 0; x < 12; ++x)
        made.chunk(x, 0).set(1, 30, 1, 1);
    made.chunk(5, 0).set(3, 900, 3, 1);
    made.chunk(6, 0).set(3, 500, 3, 1);
    const TemporaryFolder folder;
    test::write_files(folder.path(), made.files(Made::kFlat));
    MinecraftWorldOptions options{folder.path(), "overworld", std::size_t{64} << 20, 1};
    options.max_surveyed = 4;  // chunks 0, 3, 6, 9
    const auto world = open_minecraft_world(options, test::shipped_blocks());
    CHECK(world->info().bounds == voxel::VoxelBounds{{0, -64, 0}, {192, 512, 16}});
    CHECK(world->damage().empty());
    CHECK(world->box({0, 1, 1, 0})->solid(99 - 64, 500 - 256, 3));
    CHECK(world->box({0, 1, 0, 0})->solid(81 - 64, 30, 1));
    REQUIRE(world->damage().size() == 1);
    CHECK_THAT(
        world->damage()[0],
        test::contains("chunk 5, 0: blocks at y = 16 to 912 reach outside the world's heights"));
}

TEST_CASE("links are followed, but not round in circles", "[raytracer][minecraft]") {
    const TemporaryFolder folder;
    const TemporaryFolder disk;
    const MadeWorld made = test::random_world(9, 0, 10);
    test::write_files(disk.path(), made.files(Made::kFlat));
    test::write_bytes(folder.path() / "level.dat", test::level_dat_nbt("linked"));
    std::filesystem::create_directory_symlink(disk.path() / "region", folder.path() / "region");
    std::filesystem::create_directory_symlink(folder.path(), folder.path() / "again");
    std::filesystem::create_symlink("self", folder.path() / "self");
    const auto world = test::open_made(folder.path());
    CHECK(test::differing_voxels(*world, made) == 0);
    CHECK(world->damage().empty());
}

TEST_CASE("dimensions are distinguished, and one that is not there is named",
          "[raytracer][minecraft]") {
    const TemporaryFolder folder;
    const std::vector<std::pair<std::string, std::string>> places = {
        {"", "overworld"},
        {"DIM-1/", "nether"},
        {"dimensions/minecraft/the_end/", "end"},
        {"DIM7/", "DIM7"},
        {"dimensions/pack/moon/", "pack:moon"},
        {"dimensions/pack/deep/er/moon/", "pack:deep/er/moon"},
        {"dimensions/pack/dimensions/x/y/", "pack:dimensions/x/y"}};
    for (std::size_t i = 0; i < places.size(); ++i) {
        MadeWorld made;
        made.chunk(static_cast<int>(i), 0).set(3, 40, 3, 1);
        for (const auto& [name, bytes] : made.files(Made::kFlat))
            test::write_bytes(folder.path() / (places[i].first + name), bytes);
    }
    // Other files that are named as regions are none.
    for (const char* other : {"entities/", "dimensions/pack/moon/entities/", "DIM-1/poi/"})
        test::write_bytes(folder.path() / (std::string(other) + "r.0.0.mca"), Bytes(100, 1));
    test::write_bytes(folder.path() / "level.dat", test::level_dat_nbt("made"));
    for (std::size_t i = 0; i < places.size(); ++i) {
        const auto world = test::open_made(folder.path(), places[i].second);
        INFO(places[i].second);
        CHECK(world->info().bounds.min[0] == static_cast<int>(i) * 16);
        CHECK(world->damage().empty());
    }
    CHECK_THROWS_WITH(test::open_made(folder.path(), "attic"),
                      test::contains("no dimension 'attic'; allowed: overworld, DIM7, end, nether, "
                                     "pack:deep/er/moon, pack:dimensions/x/y, pack:moon"));
    CHECK(describe(folder.path(), "", false, 1).dimensions.size() == places.size());
    // Without level.dat they are found as well.
    std::filesystem::remove(folder.path() / "level.dat");
    CHECK(describe(folder.path(), "", false, 1).dimensions.size() == places.size());
}

TEST_CASE("a world lies in a folder that is named as one of a world's own",
          "[raytracer][minecraft]") {
    const TemporaryFolder folder;
    const std::filesystem::path world = folder.path() / "dimensions/my/world";
    const MadeWorld made = test::random_world(2, 0, 5);
    test::write_files(world, made.files(Made::kFlat));
    test::write_bytes(world / "level.dat", test::level_dat_nbt("made"));
    CHECK(test::differing_voxels(*test::open_made(folder.path()), made) == 0);
}

TEST_CASE("of a dimension at its old and its new place the one of level.dat's version counts",
          "[raytracer][minecraft]") {
    struct Case {
        const char* name;
        std::optional<int> data_version;  ///< of level.dat, if there is one
        bool new_counts;
    };
    const auto c = GENERATE(values<Case>({{"before 1.9, without a version", 0, false},
                                          {"1.21.11", 4671, false},
                                          {"before the move", 4773, false},
                                          {"26.1", 4786, true},
                                          {"no level.dat", std::nullopt, true}}));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        for (const auto& [place, x] : {std::pair{"", 0},
                                       {"dimensions/minecraft/overworld/", 1},
                                       {"DIM-1/", 2},
                                       {"dimensions/minecraft/the_nether/", 3},
                                       {"DIM1/", 4}}) {
            MadeWorld made;
            made.chunk(x, 0).set(3, 40, 3, 1);
            test::write_files(folder.path() / place, made.files(Made::kFlat));
        }
        if (c.data_version)
            test::write_bytes(folder.path() / "level.dat",
                              test::level_dat_nbt("made", *c.data_version));
        const auto found = [&](const char* dimension) {
            return test::open_made(folder.path(), dimension)->info().bounds.min[0] / 16;
        };
        CHECK(found("overworld") == (c.new_counts ? 1 : 0));
        CHECK(found("nether") == (c.new_counts ? 3 : 2));
        CHECK(found("end") == 4);
        const WorldFacts facts = describe(folder.path(), "", false, 1);
        std::vector<std::string> names;
        for (const DimensionFacts& dimension : facts.dimensions)
            names.push_back(dimension.name);
        CHECK(names == std::vector<std::string>{"overworld", "end", "nether"});
        REQUIRE(facts.dimensions.at(0).notes.size() == 1);
        const std::string said = c.new_counts
                                     ? "region: passed over, the game since 26.1 reads "
                                       "dimensions/minecraft/overworld/region"
                                     : "dimensions/minecraft/overworld/region: passed over, the "
                                       "game of level.dat, before 26.1, reads region";
        CHECK(facts.dimensions.at(0).notes.front() == said);
    }
}

TEST_CASE("data versions are named as the game's", "[raytracer][minecraft]") {
    for (const auto& [data_version, name] : {std::pair{100, "before 1.9 (100)"},
                                             {169, "1.9"},
                                             {2586, "1.16.5"},
                                             {4554, "1.21.9"},
                                             {4671, "1.21.11"},
                                             {4700, "after 1.21.11 (4700)"},
                                             {4786, "26.1"},
                                             {4903, "26.2"},
                                             {5023, "26.3"},
                                             {6000, "after 26.3 (6000)"}})
        CHECK(game_version(data_version) == name);
}

TEST_CASE("of a world that the game brought up to date the newest files count",
          "[raytracer][minecraft]") {
    const TemporaryFolder folder;
    MadeWorld old;
    MadeWorld fresh;
    old.chunk(0, 0).set(0, 5, 0, 1);
    old.chunk(40, 0).set(0, 7, 0, 1);
    fresh.chunk(0, 0).set(0, 9, 0, 1);
    test::write_files(folder.path(), old.files(Made::kColumns));
    test::write_files(folder.path(), fresh.files(Made::kFlat));
    test::write_files(folder.path(), alpha_files(old, true));
    const auto world = test::open_made(folder.path());
    CHECK(world->info().bounds == voxel::VoxelBounds{{0, 7, 0}, {656, 10, 16}});
    const WorldFacts facts = describe(folder.path(), "", false, 1);
    CHECK(facts.format == "Anvil+McRegion");
    CHECK(facts.dimensions.at(0).notes.size() == 3);
}

TEST_CASE("one file alone is a world: a region under any name, a chunk under any name",
          "[raytracer][minecraft]") {
    const TemporaryFolder folder;
    const MadeWorld made = test::random_world(4, -10, 20);
    MadeWorld corner;  // what lies in region -1, 0
    for (const auto& [place, chunk] : made.chunks)
        if (chunk.x < 0 && chunk.z >= 0)
            corner.chunks[place] = chunk;
    const Bytes region = corner.files(Made::kFlat).at("region/r.-1.0.mca");
    for (const char* name : {"r.-1.0.mca", "some name.mca"}) {
        test::write_bytes(folder.path() / name, region);
        INFO(name);
        CHECK(test::differing_voxels(*test::open_made(folder.path() / name), corner) == 0);
        CHECK(looks_like_minecraft(folder.path() / name));
    }
    MadeWorld single;
    single.chunk(-7, 12).set(3, 100, 4, 3);
    test::write_bytes(folder.path() / "odd.chunk",
                      test::chunk_nbt(single.chunk(-7, 12), Made::kPadded));
    CHECK(test::differing_voxels(*test::open_made(folder.path() / "odd.chunk"), single) == 0);
    test::write_bytes(folder.path() / "text.nbt", Bytes(100, 'x'));
    CHECK_THROWS_WITH(test::open_made(folder.path() / "text.nbt"),
                      test::contains("none of its chunks can be read"));
}

TEST_CASE("a side-car gives a world its place, and its blocks their meaning",
          "[raytracer][minecraft]") {
    const TemporaryFolder folder;
    const MadeWorld made = test::random_world(6, -10, 20);
    test::write_files(folder.path(), made.files(Made::kFlat));
    test::write_bytes(folder.path() / "level.dat", test::level_dat_nbt("made"));
    voxel::SideCar car;
    car.world.title = "Bled";
    car.world.crs = "EPSG:3794";
    car.world.voxel_m = car.world.crs_units_per_voxel = 0.5;
    car.offset = {860'000, 912, -270'000 + 16};
    car.offset[0] -= car.offset[0] % 16;
    car.offset[2] -= car.offset[2] % 16;
    voxel::write_side_car(folder.path() / "terravox.json", car);
    {
        const auto world = test::open_made(folder.path());
        CHECK(world->info().title == "Bled");
        CHECK(world->info().crs == "EPSG:3794");
        CHECK(world->info().voxel_m == 0.5);
        CHECK(test::differing_voxels(*world, made, car.offset) == 0);
    }
    car.blocks["minecraft:dirt"] = voxel::Material::kOrangeRoof;
    voxel::write_side_car(folder.path() / "terravox.json", car);
    {
        const auto world = test::open_made(folder.path());
        const voxel::BoxRange range = voxel::boxes_over(world->info().bounds, 0);
        int roofs = 0;
        for (int bz = range.min.bz; bz < range.max.bz; ++bz)
            for (int by = range.min.by; by < range.max.by; ++by)
                for (int bx = range.min.bx; bx < range.max.bx; ++bx)
                    if (const auto box = world->box({0, bx, by, bz}))
                        for (const auto& attr : box->attrs())
                            roofs += attr.material == voxel::Material::kOrangeRoof ? 1 : 0;
        CHECK(roofs > 1000);
    }
    car.offset[1] = 8;
    voxel::write_side_car(folder.path() / "terravox.json", car);
    CHECK_THROWS_WITH(test::open_made(folder.path()),
                      test::contains("offset 8; allowed for a Minecraft world: multiples of 16"));
}

TEST_CASE("paths without a world are distinguished from damage", "[raytracer][minecraft]") {
    const TemporaryFolder folder;
    CHECK_THROWS_AS(test::open_made(folder.path() / "nowhere"), util::UsageError);
    CHECK_THROWS_WITH(test::open_made(folder.path()), test::contains("no level.dat and no chunks"));
    CHECK_FALSE(looks_like_minecraft(folder.path()));
    test::write_bytes(folder.path() / "a/level.dat", test::level_dat_nbt("a"));
    CHECK_THROWS_WITH(test::open_made(folder.path()),
                      test::contains("no dimension 'overworld'; allowed: none is there"));
    CHECK(looks_like_minecraft(folder.path()));
    test::write_bytes(folder.path() / "b/level.dat", test::level_dat_nbt("b"));
    CHECK_THROWS_WITH(test::open_made(folder.path()), test::contains("it holds 2 worlds (a, b)"));
    CHECK_THROWS_AS(
        open_minecraft_world({folder.path(), "overworld", 1000, 1}, test::shipped_blocks()),
        util::UsageError);
}

TEST_CASE("a world of the Bedrock edition is told, with what helps", "[raytracer][minecraft]") {
    const TemporaryFolder folder;
    const std::map<std::string, Bytes> files{
        {"level.dat", {10, 0, 0, 0, 0, 0, 0, 0}}, {"db/CURRENT", {1}}, {"db/000005.ldb", {1}}};
    const std::map<std::string, Bytes> database{{"db/CURRENT", {1}}};
    test::write_files(folder.path() / "world", files);
    test::write_files(folder.path() / "database", database);
    test::write_zip(folder.path() / "world.mcworld", files);
    test::write_zip(folder.path() / "world.zip", files);
    test::write_zip(folder.path() / "named anyhow",
                    {{"mine/level.dat", {1}}, {"mine/db/CURRENT", {1}}});
    for (const char* name : {"world", "world.mcworld", "world.zip", "named anyhow", "database",
                             "database/db", "world/level.dat", "world/db/"}) {
        INFO(name);
        CHECK(looks_like_minecraft(folder.path() / name));
        CHECK_THROWS_AS(test::open_made(folder.path() / name), util::UsageError);
        CHECK_THROWS_WITH(test::open_made(folder.path() / name),
                          test::contains("of the Bedrock edition (or Education)") &&
                              test::contains("Chunker or Amulet"));
    }
    // A world of the Java edition with such a folder is one.
    test::write_files(folder.path() / "java/db", {{"CURRENT", {1}}});
    test::write_files(folder.path() / "java", test::random_world(2, 0, 5).files(Made::kFlat));
    CHECK(test::open_made(folder.path() / "java")->damage().empty());
}

TEST_CASE("an archive of several worlds is recognised, and they are named",
          "[raytracer][minecraft]") {
    const TemporaryFolder folder;
    test::write_zip(folder.path() / "a.zip", {{"one/level.dat", test::level_dat_nbt("one")},
                                              {"two/level.dat", test::level_dat_nbt("two")}});
    CHECK(looks_like_minecraft(folder.path() / "a.zip"));
    CHECK_THROWS_WITH(test::open_made(folder.path() / "a.zip"),
                      test::contains("it holds 2 worlds (one, two)"));
    test::write_zip(folder.path() / "b.zip", {{"readme.txt", {1}}});
    CHECK_FALSE(looks_like_minecraft(folder.path() / "b.zip"));
}

}  // namespace
}  // namespace terravox::minecraft
