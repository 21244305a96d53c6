#include <cmath>

#include "raytracer/analyse/evaluators/plane_light.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/analyse/evaluators/period_light.hpp"

namespace {

using namespace terravox;
using test::ArrayWorld;
using test::in_the_open;
using test::kTown;
using test::Light;
using test::Measured;
using voxel::Material;

scene::Scene energy_scene(const char* from, const char* to) {
    return test::energy_scene(core::AnalysisKind::kEnergy, from, to);
}

std::unique_ptr<ArrayWorld> flat(int half, int top) {
    auto world = std::make_unique<ArrayWorld>(ArrayWorld::Coord{-half, -2, -half},
                                              ArrayWorld::Coord{half, top, half});
    world->fill({-half, -2, -half}, {half, 0, half}, Material::kGrass);
    world->editable_info().centre = kTown;
    return world;
}

}  // namespace

TEST_CASE("an open plane gets the energy of the closed form", "[raytracer][analyse]") {
    const auto world = flat(12, 2);
    scene::Scene scene = energy_scene("2026-06-01", "2026-06-30");
    const Light expected = in_the_open(scene, {0, 1, 0}, 0);
    REQUIRE(expected.beam > 100);
    for (const double bin_deg : {0.0, 3.0}) {
        INFO("bins of " << bin_deg);
        scene.analysis.bin_deg = bin_deg;
        const Measured raster(*world, scene, {});
        for (int z = -12; z < 12; ++z)
            for (int x = -12; x < 12; ++x) {
                REQUIRE(value(raster, x, z, "hole") == 0);
                REQUIRE(value(raster, x, z, "slope") == 0);
                REQUIRE(value(raster, x, z, "aspect") == static_cast<double>(core::kNoData));
                REQUIRE(value(raster, x, z, "beam") == Approx(expected.beam).epsilon(1e-3));
                REQUIRE(value(raster, x, z, "diffuse") == Approx(expected.diffuse).epsilon(1e-4));
                REQUIRE(value(raster, x, z, "reflected") == 0);
                REQUIRE(value(raster, x, z, "kwh_m2") ==
                        Approx(expected.beam + expected.diffuse).epsilon(1e-3));
            }
    }
    // What Perez takes from the even sky comes from around the sun.
    scene.analysis.diffuse = "perez";
    const Measured perez(*world, scene, {});
    CHECK(value(perez, 0, 0, "diffuse") == Approx(expected.diffuse).epsilon(0.01));
}

TEST_CASE("slopes made of voxels get the energy of the plane", "[raytracer][analyse]") {
    struct Slope {
        const char* name;
        double rise;  // to the north for each metre, so that it faces south; below 0: north
    };
    for (const Slope& slope : {Slope{"14 degrees", 0.25}, Slope{"30 degrees", 0.57735},
                               Slope{"45 degrees", 1}, Slope{"to the north", -0.5}}) {
        INFO(slope.name);
        constexpr int kHalf = 40;
        ArrayWorld world({-kHalf, -60, -kHalf}, {kHalf, 60, kHalf});
        world.fill_with([&](int, int y, int z) {
            return y < std::floor(-slope.rise * z) ? Material::kRoof : Material::kAir;
        });
        world.editable_info().centre = kTown;
        const scene::Scene scene = energy_scene("2026-01-01", "2026-12-31");
        Measured::Options options;
        options.area = voxel::VoxelBounds{{-4, -60, -16}, {4, 60, 16}};
        const Measured raster(world, scene, options);
        const core::Vec3 normal = core::normalized({0, 1, slope.rise});
        const Light expected = in_the_open(scene, normal, 0);
        double beam = 0;
        double diffuse = 0;
        double reflected = 0;
        double slope_deg = 0;
        constexpr int kCells = 8 * 32;
        for (int z = -16; z < 16; ++z)
            for (int x = -4; x < 4; ++x) {
                beam += value(raster, x, z, "beam") / kCells;
                diffuse += value(raster, x, z, "diffuse") / kCells;
                slope_deg += value(raster, x, z, "slope") / kCells;
                REQUIRE(value(raster, x, z, "aspect") == (slope.rise > 0 ? 180 : 0));
                reflected += value(raster, x, z, "reflected") / kCells;
            }
        CHECK(slope_deg == Approx(std::atan(std::abs(slope.rise)) * 180 / det::kPi).margin(0.8));
        CHECK(beam == Approx(expected.beam).epsilon(0.02));
        CHECK(diffuse == Approx(expected.diffuse).epsilon(0.02));
        CHECK(reflected == Approx(expected.reflected).epsilon(0.2));
    }
}

TEST_CASE("crowns let a share of light through by season, and what is solid lets none",
          "[raytracer][analyse]") {
    // A hall whose walls and roof are leaves, several voxels thick.
    const auto world = flat(9, 12);
    world->fill({-9, 0, -9}, {9, 11, 9}, Material::kHighVegetation);
    world->fill({-8, 0, -8}, {8, 9, 8}, Material::kMediumVegetation);
    world->fill({-7, 0, -7}, {7, 8, 7}, Material::kHighVegetation);
    world->fill({-6, 0, -6}, {6, 7, 6}, Material::kAir);
    struct Season {
        const char* day;
        const char* light;
        double share;
    };
    const Season seasons[] = {
        {"2026-06-21", "0.25", 0.25},    {"2026-06-21", "0.25,0.5", 0.25},
        {"2026-12-21", "0.25,0.5", 0.5}, {"2026-12-21", "0.25,0", 0},
        {"2026-06-21", "0", 0},          {"2026-06-21", "1", 1},
    };
    for (const Season& season : seasons) {
        INFO(season.day << ", " << season.light);
        scene::Scene scene = energy_scene(season.day, season.day);
        scene.analysis.surface = core::AnalysisSurface::kGround;
        scene.analysis.crown_light = season.light;
        const Light open = in_the_open(scene, {0, 1, 0}, 0);
        const Measured inside(*world, scene, {});
        for (const int x : {0, 3, -4}) {
            CHECK(value(inside, x, 1, "beam") ==
                  Approx(open.beam * season.share).epsilon(5e-3).margin(1e-9));
            CHECK(value(inside, x, 1, "diffuse") ==
                  Approx(open.diffuse * season.share).epsilon(1e-4).margin(1e-9));
            CHECK(value(inside, x, 1, "sun_hours") == 0);
        }
    }
    world->fill({-6, 6, -6}, {6, 7, 6}, Material::kBridge);
    world->fill({-6, 0, -6}, {-5, 7, 6}, Material::kTrunk);
    world->fill({5, 0, -6}, {6, 7, 6}, Material::kWall);
    world->fill({-6, 0, -6}, {6, 7, -5}, Material::kWire);
    world->fill({-6, 0, 5}, {6, 7, 6}, Material::kWall);
    scene::Scene scene = energy_scene("2026-06-21", "2026-06-21");
    scene.analysis.surface = core::AnalysisSurface::kGround;
    scene.analysis.crown_light = "0.25";
    scene.analysis.thin_blocks = true;
    const Measured closed(*world, scene, {});
    CHECK(value(closed, 0, 0, "kwh_m2") == 0);
    // Past trunks and wires light of the sky comes in through the crowns behind them.
    scene.analysis.thin_blocks = false;
    const Measured passed(*world, scene, {});
    CHECK(value(passed, 0, 0, "diffuse") > 0);
    scene.analysis.crown_light = "0";
    CHECK(value(Measured(*world, scene, {}), 0, 0, "kwh_m2") == 0);
}

TEST_CASE("a cell whose light or neighbours are behind a hole has no energy",
          "[raytracer][analyse]") {
    ArrayWorld world({-40, -2, -20}, {100, 30, 20});
    world.fill({-40, -2, -20}, {100, 0, 20}, Material::kGrass);
    world.editable_info().centre = kTown;
    world.make_hole({0, 1, 0, 0});
    const Measured raster(world, energy_scene("2026-06-21", "2026-06-21"), {});
    for (const int x : {90, 63, 62, 50}) {
        INFO(x);
        CHECK(raster.at(x, 10, "hole") == 1);
        CHECK(raster.at(x, 10, "kwh_m2") == core::kNoData);
        // Those that are themselves behind the hole have nothing at all.
        const bool is_seen = x < 64;
        CHECK(raster.at(x, 10, "material") ==
              (is_seen ? static_cast<float>(Material::kGrass) : core::kNoData));
    }
}
