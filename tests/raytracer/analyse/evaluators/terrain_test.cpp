#include "tests/catch.hpp"
#include "tests/raytracer/analyse/evaluators/measured.hpp"

namespace {

using namespace terravox;
using test::ArrayWorld;
using test::Measured;
using voxel::Material;

/// A meadow with a house, a tree, a deck on stilts, a pond, and a column without anything.
std::unique_ptr<ArrayWorld> meadow() {
    auto world =
        std::make_unique<ArrayWorld>(ArrayWorld::Coord{0, 0, 0}, ArrayWorld::Coord{40, 30, 40});
    world->fill({0, 0, 0}, {40, 5, 40}, Material::kGrass);
    world->fill({4, 5, 4}, {12, 11, 12}, Material::kWall);
    world->fill({4, 11, 4}, {12, 12, 12}, Material::kOrangeRoof);
    world->fill({20, 7, 4}, {25, 15, 9}, Material::kHighVegetation);
    world->fill({22, 5, 6}, {23, 12, 7}, Material::kTrunk);
    world->fill({4, 12, 20}, {12, 13, 28}, Material::kBridge);
    world->fill({20, 3, 20}, {28, 5, 28}, Material::kWater);
    world->fill({35, 0, 35}, {36, 5, 36}, Material::kAir);
    return world;
}

Measured measure_terrain(voxel::World& world, const Measured::Options& options = {}) {
    return {world, test::analysis_scene(core::AnalysisKind::kTerrain), options};
}

}  // namespace

TEST_CASE("surface and ground of a cell are the tops of its voxels", "[raytracer][analyse]") {
    struct Cell {
        const char* name;
        int x;
        int z;
        float surface;
        float ground;
        Material material;
    };
    const float none = core::kNoData;
    const Cell cells[] = {
        {"meadow", 1, 1, 5, 5, Material::kGrass},
        {"roof: enclosed, so the ground is unknown", 8, 8, 12, none, Material::kOrangeRoof},
        {"crown: the ground below it", 21, 5, 15, 5, Material::kHighVegetation},
        {"trunk stands on the ground, which it covers", 22, 6, 15, none, Material::kHighVegetation},
        {"deck: the ground below it", 8, 24, 13, 5, Material::kBridge},
        {"water is a surface", 24, 24, 5, 5, Material::kWater},
        {"nothing", 35, 35, none, none, Material::kAir},
    };
    const auto world = meadow();
    const Measured raster = measure_terrain(*world);
    for (const Cell& c : cells) {
        INFO(c.name);
        CHECK(raster.at(c.x, c.z, "dsm") == c.surface);
        CHECK(raster.at(c.x, c.z, "dtm") == c.ground);
        CHECK(raster.at(c.x, c.z, "material") ==
              (c.surface == none ? none : static_cast<float>(c.material)));
        CHECK(raster.at(c.x, c.z, "hole") == 0);
    }
}

TEST_CASE("cells of several voxels are measured at their middle, east and south of a border",
          "[raytracer][analyse]") {
    const auto world = meadow();
    Measured::Options options;
    options.edge_m = 8;
    const Measured raster = measure_terrain(*world, options);
    // The cell [0, 8) x [0, 8) has its middle at the corner of voxel (4, 4): the house.
    CHECK(raster.at(0, 0, "dsm") == 12);
    CHECK(raster.at(8, 0, "dsm") == 5);
}

TEST_CASE("a missing box is a hole in the terrain, and no depth", "[raytracer][analyse]") {
    ArrayWorld world({0, 0, 0}, {100, 10, 20});
    world.fill({0, 0, 0}, {100, 5, 20}, Material::kGrass);
    world.make_hole({0, 1, 0, 0});
    const Measured raster = measure_terrain(world);
    CHECK(raster.at(63, 3, "dsm") == 5);
    CHECK(raster.at(64, 3, "dsm") == core::kNoData);
    CHECK(raster.at(64, 3, "hole") == 1);
    CHECK(raster.counts().holes.size() == 1);
}
