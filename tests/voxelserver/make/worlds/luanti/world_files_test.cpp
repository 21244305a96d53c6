#include <algorithm>
#include <random>
#include <set>
#include <sstream>

#include "common/util/error.hpp"
#include "common/voxel/pyramid_world.hpp"
#include "tests/catch.hpp"
#include "tests/common/content.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/make/worlds/luanti/made_luanti.hpp"
#include "voxelserver/make/worlds/luanti/block_survey.hpp"
#include "voxelserver/make/worlds/luanti/luanti_world.hpp"
#include "voxelserver/make/worlds/luanti/node_block.hpp"

namespace terravox::luanti {
namespace {

namespace fs = std::filesystem;
using test::contains;
using test::TemporaryFolder;
using test::write_content;
using test::luanti::shipped_nodes;
using test::luanti::to_material;
using voxel::Material;

TEST_CASE("a world is a folder with a world.mt, or a map.sqlite", "[luanti]") {
    const TemporaryFolder folder;
    const fs::path& at = folder.path();
    write_content(at / "plain" / "world.mt", "");
    write_content(at / "both" / "world.mt", "");
    write_content(at / "both" / "level.dat", "");
    write_content(at / "map" / "map.sqlite", "");
    write_content(at / "map" / "players.sqlite", "");
    CHECK(looks_like_luanti(at / "plain"));
    CHECK(looks_like_luanti(at / "map" / "map.sqlite"));
    CHECK_FALSE(looks_like_luanti(at / "both"));
    CHECK_FALSE(looks_like_luanti(at / "map"));
    CHECK_FALSE(looks_like_luanti(at / "map" / "players.sqlite"));
    CHECK_FALSE(looks_like_luanti(at / "none"));
}

TEST_CASE("a world's title is that of world.mt, else the folder's name", "[luanti]") {
    const TemporaryFolder folder;
    const fs::path world = folder.path() / "My World";
    write_content(world / "map.sqlite", "");
    CHECK(find_world_files(world / "map.sqlite").title == "My World");
    write_content(world / "world.mt", "gameid = minetest\r\nthis is no setting\nbackend = sqlite3");
    CHECK(find_world_files(world).title == "My World");
    CHECK(find_world_files(world).game == "minetest");
    write_content(world / "world.mt", "world_name =  Sol III \nbackend=sqlite3\n");
    CHECK(find_world_files(world).title == "Sol III");
    CHECK(find_world_files(world).map == world / "map.sqlite");
}

TEST_CASE("a world that keeps its map elsewhere is refused with what is allowed", "[luanti]") {
    struct Case {
        const char* name;
        const char* settings;
        const char* reason;
    };
    const auto c = GENERATE(values<Case>({
        {"leveldb", "backend = leveldb\n", "backend = leveldb in its world.mt; allowed: sqlite3"},
        {"postgresql", "backend = postgresql\n", "backend = postgresql"},
        {"redis", "backend = redis\n", "backend = redis"},
        {"dummy", "backend = dummy\n", "backend = dummy"},
        {"larger blocks", "blocksize = 32\n", "blocksize = 32 in its world.mt; allowed: 16"},
        {"never played", "backend = sqlite3\n", "no map.sqlite"},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        write_content(folder.path() / "world.mt", c.settings);
        CHECK_THROWS_AS(find_world_files(folder.path()), util::UsageError);
        CHECK_THROWS_WITH(find_world_files(folder.path()),
                          contains(folder.path().string()) && contains(c.reason));
    }
}

TEST_CASE("a world.mt of more than 1 MiB is refused", "[luanti]") {
    const TemporaryFolder folder;
    write_content(folder.path() / "map.sqlite", "");
    write_content(folder.path() / "world.mt", std::string((std::size_t{1} << 20) + 1, '\n'));
    CHECK_THROWS_WITH(find_world_files(folder.path()), contains("more than 1 MiB"));
}

TEST_CASE("nodes of the common games, and by their names those of other mods, have their materials",
          "[luanti]") {
    struct Case {
        Material material;
        const char* nodes;
    };
    for (const Case& c : {
             Case{Material::kAir, "air ignore default:sign_wall_wood carts:powerrail"},
             Case{Material::kRock,
                  "default:stone default:stone_with_coal mcl_core:stone "
                  "mcl_deepslate:deepslate technic:marble "
                  "moreores:mineral_silver"},
             Case{Material::kSoil, "default:dirt ethereal:grove_dirt"},
             Case{Material::kGrass, "default:dirt_with_grass mcl_core:dirt_with_grass"},
             Case{Material::kSnow, "default:dirt_with_snow"},
             Case{Material::kSand, "default:sand somemod:red_sand"},
             Case{Material::kGround, "default:gravel"},
             Case{Material::kWater,
                  "default:water_source default:river_water_flowing "
                  "mcl_core:water_source somemod:swamp_water_source"},
             Case{Material::kLava, "default:lava_source"},
             Case{Material::kIce, "default:ice"},
             Case{Material::kGlass, "default:glass mcl_core:glass_light_blue"},
             Case{Material::kTrunk,
                  "default:tree default:pine_tree mcl_core:sprucetree "
                  "somemod:maple_tree"},
             Case{Material::kHighVegetation,
                  "default:jungleleaves default:pine_needles "
                  "mcl_core:birchleaves somemod:maple_leaves"},
             Case{Material::kMediumVegetation, "default:papyrus"},
             Case{Material::kLowVegetation,
                  "default:grass_3 flowers:geranium "
                  "mcl_flowers:tallgrass"},
             Case{Material::kMasonry, "default:cobble stairs:slab_cobble"},
             Case{Material::kWood,
                  "default:junglewood stairs:stair_outer_pine_wood "
                  "doors:door_wood_a mcl_core:darkwood somemod:maple_planks"},
             Case{Material::kPlain, "default:steelblock wool:dark_green"},
             Case{Material::kWire, "xpanes:bar_flat"},
             Case{Material::kLamp,
                  "default:torch_wall mcl_torches:torch_wall "
                  "somemod:street_lamp"},
         }) {
        std::istringstream nodes(c.nodes);
        for (std::string node; nodes >> node;) {
            INFO(node);
            CHECK(voxel::material_name(to_material(node)) == voxel::material_name(c.material));
        }
    }
}

TEST_CASE("a node that no entry fits is shown as unknown, and counted once", "[luanti]") {
    NodeAppearances appearances(shipped_nodes());
    for (int again = 0; again < 3; ++again) {
        CHECK(appearances.of("xyz:qqq").material == Material::kUnknown);
        CHECK(appearances.of("xyz:zzz").material == Material::kUnknown);
        CHECK(appearances.of("default:stone").material == Material::kRock);
    }
    CHECK(appearances.unknown_names() == 2);
}

TEST_CASE("the mod is a part of a node's name", "[luanti]") {
    CHECK(to_material("wool:white") == Material::kPlain);
    CHECK_FALSE(shipped_nodes().of_full_name("xyz:white").known);
}

TEST_CASE("an index lists the columns of boxes of every level that blocks lie in", "[luanti]") {
    const unsigned seed = 17;
    CAPTURE(seed);
    std::mt19937 random(seed);
    BlockIndex index;
    std::set<std::pair<int, int>> columns;
    for (int i = 0; i < 200; ++i) {
        const auto any = [&] { return static_cast<std::int32_t>(random() % 4096) - 2048; };
        const BlockPlace place{any(), any(), any()};
        index.add(place);
        columns.insert({voxel::floor_div(place.x, 4), voxel::floor_div(place.z, 4)});
    }
    const int levels = voxel::levels_for(index.bounds());
    for (int level = 0; level < levels; ++level) {
        CAPTURE(level);
        const std::int32_t half = std::max(1, 512 >> level) + 1;
        int wrong = 0;
        for (std::int32_t bz = -half; bz < half; ++bz) {
            for (std::int32_t bx = -half; bx < half; ++bx)
                wrong += index.holds(level, bx, bz) != columns.contains({bx, bz}) ? 1 : 0;
        }
        CHECK(wrong == 0);
        std::set<std::pair<int, int>> coarser;
        for (const auto& [bx, bz] : columns)
            coarser.insert({voxel::floor_div(bx, 2), voxel::floor_div(bz, 2)});
        columns = coarser;
    }
}

TEST_CASE("a column's heights hold all of its blocks and no more", "[luanti]") {
    BlockIndex index;
    index.add({-5, 7, 0});
    index.add({-8, -3, 3});
    index.add({0, 100, 0});
    CHECK(index.heights(-2, 0).begin == -3);
    CHECK(index.heights(-2, 0).end == 8);
    CHECK(index.heights(0, 0).begin == 100);
    CHECK(index.heights(0, 0).end == 101);
    const BlockIndex::Heights outside = index.heights(5000, -5000);
    CHECK(outside.begin == outside.end);
}

}  // namespace
}  // namespace terravox::luanti
