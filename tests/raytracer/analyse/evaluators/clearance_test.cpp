#include <memory>
#include <string_view>
#include <vector>

#include "tests/catch.hpp"
#include "tests/raytracer/analyse/evaluators/measured.hpp"

namespace {

using namespace terravox;
using test::ArrayWorld;
using test::Measured;
using voxel::Material;

/// A meadow of which each column along x has something else above it.
struct Column {
    const char* name;
    float height;  ///< metres above the ground
    Material material = Material::kAir;
    /// What is above the meadow, whose top is at 5: [from, to) of a material.
    struct Part {
        int from;
        int to;
        Material material;
    };
    std::vector<Part> parts = {};
};

constexpr int kGround = 5;
constexpr int kThingWidth = 3;  // of a column's things, so that the middle is enclosed

std::vector<Column> columns() {
    using enum Material;
    const float none = core::kNoData;
    return {
        {"nothing above", none},
        {"a deck", 7, kBridge, {{12, 13, kBridge}}},
        {"a thick deck", 7, kBridge, {{12, 15, kBridge}}},
        {"a deck with a lamp and grass on it",
         7,
         kBridge,
         {{12, 13, kBridge}, {13, 14, kLowVegetation}, {18, 19, kLamp}}},
        {"two decks", 3, kBridge, {{8, 9, kBridge}, {14, 15, kBridge}}},
        {"a crown", 4, kHighVegetation, {{9, 16, kHighVegetation}}},
        {"a hedge on the ground", 0, kMediumVegetation, {{5, 7, kMediumVegetation}}},
        {"a wire above a crown", 4, kHighVegetation, {{9, 12, kHighVegetation}, {15, 16, kWire}}},
        {"a wire above grass", 10, kWire, {{5, 6, kLowVegetation}, {15, 16, kWire}}},
        {"grass alone", none, kAir, {{5, 7, kLowVegetation}}},
        {"a house", none, kAir, {{5, 12, kWall}, {12, 13, kOrangeRoof}}},
        {"a tower, thicker than a deck", none, kAir, {{8, 16, kWall}}},
        {"a trunk", none, kAir, {{5, 12, kTrunk}, {12, 15, kHighVegetation}}},
    };
}

std::unique_ptr<ArrayWorld> meadow(const std::vector<Column>& all) {
    const int length = kThingWidth * static_cast<int>(all.size());
    auto world = std::make_unique<ArrayWorld>(ArrayWorld::Coord{0, -20, 0},
                                              ArrayWorld::Coord{length, 30, kThingWidth});
    world->fill({0, -20, 0}, {length, kGround - 1, kThingWidth}, Material::kRock);
    world->fill({0, kGround - 1, 0}, {length, kGround, kThingWidth}, Material::kGrass);
    for (int i = 0; i < static_cast<int>(all.size()); ++i)
        for (const auto& part : all[static_cast<std::size_t>(i)].parts)
            world->fill({kThingWidth * i, part.from, 0},
                        {kThingWidth * (i + 1), part.to, kThingWidth}, part.material);
    return world;
}

}  // namespace

TEST_CASE("the free height of a cell is the air below the lowest thing above its ground",
          "[raytracer][analyse]") {
    const double voxel_m = GENERATE(1.0, 0.5);
    const std::vector<Column> all = columns();
    const auto world = meadow(all);
    world->editable_info().voxel_m = voxel_m;
    Measured::Options options;
    options.edge_m = voxel_m;
    const Measured raster(*world, test::analysis_scene(core::AnalysisKind::kClearance), options);
    for (int i = 0; i < static_cast<int>(all.size()); ++i) {
        const Column& c = all[static_cast<std::size_t>(i)];
        // Eight voxels of half a metre are a deck.
        const bool is_tower = std::string_view(c.name).starts_with("a tower") && voxel_m < 1;
        CAPTURE(c.name, voxel_m);
        const float height = is_tower ? 3 : c.height;
        const bool has_value = height != core::kNoData;
        const Material material = is_tower ? Material::kWall : c.material;
        const int x = kThingWidth * i + 1;
        CHECK(raster.at(x, 1, "clearance") ==
              (has_value ? height * static_cast<float>(voxel_m) : core::kNoData));
        CHECK(raster.at(x, 1, "material") ==
              (has_value ? static_cast<float>(material) : core::kNoData));
        CHECK(raster.at(x, 1, "hole") == 0);
    }
}

TEST_CASE("a missing box is a hole in the free height, above and below", "[raytracer][analyse]") {
    const int missing = GENERATE(0, 1);
    ArrayWorld world({0, 0, 0}, {100, 300, 4});
    world.fill({0, 0, 0}, {100, 5, 4}, Material::kGrass);
    world.fill({0, 290, 0}, {100, 291, 4}, Material::kBridge);
    world.make_hole({0, 1, missing, 0});
    const Measured raster(world, test::analysis_scene(core::AnalysisKind::kClearance), {});
    CHECK(raster.at(63, 2, "clearance") == 285);
    CHECK(raster.at(64, 2, "clearance") == core::kNoData);
    CHECK(raster.at(64, 2, "material") == core::kNoData);
    CHECK(raster.at(64, 2, "hole") == 1);
}
