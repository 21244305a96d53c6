#include <sstream>

#include "tests/catch.hpp"
#include "tests/voxelserver/make/worlds/luanti/made_luanti.hpp"
#include "voxelserver/make/worlds/luanti/node_block.hpp"

namespace terravox::luanti {
namespace {

using test::luanti::shipped_nodes;
using test::luanti::to_material;
using voxel::Material;

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

}  // namespace
}  // namespace terravox::luanti
