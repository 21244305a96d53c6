// Typical colours by building and tree, and a town that has them.
#include "voxelserver/make/voxelize/steps/colour_variation.hpp"

#include <fstream>
#include <set>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using namespace terravox::test;
using voxel::Material;
using voxelize::number_of_place;
using voxelize::Tints;

namespace {

Tints read_tints(const TemporaryFolder& folder, const std::string& text) {
    const auto file = folder.path() / "mine.toml";
    std::ofstream(file) << text;
    return Tints::load(file.string());
}

}  // namespace

TEST_CASE("the tints that ship vary roofs, walls and crowns, and nothing that is measured",
          "[voxelserver][voxelize][tints]") {
    const Tints tints = Tints::load("default");
    for (const Material m : {Material::kRoof, Material::kOrangeRoof, Material::kGreyRoof,
                             Material::kFlatRoof, Material::kWall, Material::kHighVegetation}) {
        std::set<std::array<int, 3>> seen;
        for (int x = 0; x < 100; ++x) {
            const auto colour = tints.of(m, number_of_place(x, 5, 1));
            REQUIRE(colour);
            CHECK(colour == tints.of(m, number_of_place(x, 5, 1)));
            seen.insert({colour->r, colour->g, colour->b});
        }
        INFO(voxel::material_name(m));
        CHECK(seen.size() > 20);
    }
    for (const Material m : {Material::kGround, Material::kWater, Material::kRoad})
        CHECK_FALSE(tints.of(m, 1));
}

TEST_CASE("without a brightness of its own a tint is exactly one of the list",
          "[voxelserver][voxelize][tints]") {
    const TemporaryFolder folder;
    const Tints tints = read_tints(folder, "[colours]\nwall = ['#102030', '#AABBCC']\n");
    std::set<std::array<int, 3>> seen;
    for (int i = 0; i < 50; ++i) {
        const auto colour = tints.of(Material::kWall, number_of_place(i, -i, 2));
        REQUIRE(colour);
        seen.insert({colour->r, colour->g, colour->b});
    }
    CHECK(seen == std::set<std::array<int, 3>>{{0x10, 0x20, 0x30}, {0xaa, 0xbb, 0xcc}});
    CHECK_FALSE(tints.of(Material::kRoof, 7));
}

TEST_CASE("bad tints are refused, naming what is wrong", "[voxelserver][voxelize][tints][bad]") {
    struct Case {
        const char* text;
        const char* part;
    };
    const auto c = GENERATE(values<Case>({
        {"[colours]\nwall = []\n", "colours.wall"},
        {"[colours]\nwall = ['red']\n", "\"#rrggbb\""},
        {"[colours]\nwall = [7]\n", "\"#rrggbb\""},
        {"[colours]\nwool = ['#102030']\n", "colours.wool is no material"},
        {"colours = 3\n", "[colours]"},
        {"brightness = 0.7\n[colours]\n", "allowed: 0 to 0.5"},
        {"brightness = true\n[colours]\n", "allowed: 0 to 0.5"},
        {"colour = 3\n[colours]\n", "colour is no field"},
        {"", "[colours]"},
    }));
    const TemporaryFolder folder;
    INFO(c.text);
    CHECK_THROWS_AS(read_tints(folder, c.text), util::UsageError);
    CHECK_THROWS_WITH(read_tints(folder, c.text), contains("mine.toml") && contains(c.part));
}

TEST_CASE("tints that do not exist are refused with those that do",
          "[voxelserver][voxelize][tints][bad]") {
    CHECK_THROWS_WITH(Tints::load("pastel"), contains("'pastel'") && contains("default"));
    CHECK_THROWS_WITH(Tints::load("../x"), contains("default"));
    CHECK_THROWS_WITH(Tints::load("no/such.toml"), contains("no such file"));
}
