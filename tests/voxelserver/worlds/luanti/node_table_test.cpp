#include "tests/catch.hpp"
#include "tests/voxelserver/worlds/luanti/made_luanti.hpp"
#include "voxelserver/worlds/luanti/node_appearances.hpp"

namespace terravox::luanti {
namespace {

using test::luanti::material_of;
using test::luanti::shipped_nodes;
using voxel::Material;

TEST_CASE("nodes of the common games have their materials", "[luanti]") {
    struct Case {
        const char* node;
        Material material;
    };
    const auto c = GENERATE(values<Case>({
        {"air", Material::kAir},
        {"ignore", Material::kAir},
        {"default:stone", Material::kRock},
        {"default:stone_with_coal", Material::kRock},
        {"default:dirt", Material::kSoil},
        {"default:dirt_with_grass", Material::kGrass},
        {"default:dirt_with_snow", Material::kSnow},
        {"default:sand", Material::kSand},
        {"default:gravel", Material::kGround},
        {"default:water_source", Material::kWater},
        {"default:river_water_flowing", Material::kWater},
        {"default:lava_source", Material::kLava},
        {"default:ice", Material::kIce},
        {"default:glass", Material::kGlass},
        {"default:tree", Material::kTrunk},
        {"default:pine_tree", Material::kTrunk},
        {"default:jungleleaves", Material::kHighVegetation},
        {"default:pine_needles", Material::kHighVegetation},
        {"default:grass_3", Material::kLowVegetation},
        {"default:papyrus", Material::kMediumVegetation},
        {"default:cobble", Material::kMasonry},
        {"default:junglewood", Material::kWood},
        {"default:torch_wall", Material::kLamp},
        {"default:sign_wall_wood", Material::kAir},
        {"default:steelblock", Material::kPlain},
        {"stairs:slab_cobble", Material::kMasonry},
        {"stairs:stair_outer_pine_wood", Material::kWood},
        {"wool:dark_green", Material::kPlain},
        {"flowers:geranium", Material::kLowVegetation},
        {"doors:door_wood_a", Material::kWood},
        {"xpanes:bar_flat", Material::kWire},
        {"carts:powerrail", Material::kAir},
        {"mcl_core:stone", Material::kRock},
        {"mcl_core:dirt_with_grass", Material::kGrass},
        {"mcl_core:water_source", Material::kWater},
        {"mcl_core:sprucetree", Material::kTrunk},
        {"mcl_core:birchleaves", Material::kHighVegetation},
        {"mcl_core:darkwood", Material::kWood},
        {"mcl_core:glass_light_blue", Material::kGlass},
        {"mcl_torches:torch_wall", Material::kLamp},
        {"mcl_deepslate:deepslate", Material::kRock},
        {"mcl_flowers:tallgrass", Material::kLowVegetation},
    }));
    DYNAMIC_SECTION(c.node) {
        CHECK(voxel::material_name(material_of(c.node)) == voxel::material_name(c.material));
    }
}

TEST_CASE("nodes of other mods have the material that their name suggests", "[luanti]") {
    struct Case {
        const char* node;
        Material material;
    };
    const auto c = GENERATE(values<Case>({
        {"somemod:maple_leaves", Material::kHighVegetation},
        {"somemod:maple_tree", Material::kTrunk},
        {"somemod:maple_planks", Material::kWood},
        {"technic:marble", Material::kRock},
        {"moreores:mineral_silver", Material::kRock},
        {"somemod:swamp_water_source", Material::kWater},
        {"ethereal:grove_dirt", Material::kSoil},
        {"somemod:red_sand", Material::kSand},
        {"somemod:street_lamp", Material::kLamp},
    }));
    DYNAMIC_SECTION(c.node) {
        CHECK(voxel::material_name(material_of(c.node)) == voxel::material_name(c.material));
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
    CHECK(material_of("wool:white") == Material::kPlain);
    CHECK_FALSE(shipped_nodes().of_full_name("xyz:white").known);
}

}  // namespace
}  // namespace terravox::luanti
