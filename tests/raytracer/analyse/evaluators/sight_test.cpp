#include <cmath>
#include <random>

#include "common/util/error.hpp"
#include "raytracer/analyse/evaluators/sight.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/analyse/evaluators/measured.hpp"

namespace {

using namespace terravox;
using test::ArrayWorld;
using test::Measured;
using voxel::Material;
using Point = std::array<double, 3>;

/// Without curvature.
scene::Scene sight_scene(std::vector<Point> observers, double target_m = 0) {
    scene::Scene scene = test::analysis_scene(core::AnalysisKind::kSight);
    scene.analysis.observers.points = std::move(observers);
    scene.analysis.target_m = target_m;
    scene.analysis.curvature = false;
    return scene;
}

/// Only the row of cells north of z = 0.
Measured::Options one_row(int west, int east) {
    Measured::Options options;
    options.area = voxel::VoxelBounds{{west, 0, -1}, {east, 1, 0}};
    return options;
}

/// A plain whose surface is at y = 0, with random blocks on it.
std::unique_ptr<ArrayWorld> random_blocks(unsigned seed) {
    auto world = std::make_unique<ArrayWorld>(ArrayWorld::Coord{-24, -1, -24},
                                              ArrayWorld::Coord{24, 12, 24});
    world->fill({-24, -1, -24}, {24, 0, 24}, Material::kGrass);
    std::mt19937 random(seed);
    const auto below = [&](int end) {
        return static_cast<int>(random() % static_cast<unsigned>(end));
    };
    for (int i = 0; i < 60; ++i) {
        const int x = below(48) - 24;
        const int y = below(10);
        const int z = below(48) - 24;
        world->fill({x, y, z}, {x + 1 + below(5), y + 1 + below(4), z + 1 + below(5)},
                    Material::kWall);
    }
    return world;
}

}  // namespace

TEST_CASE("a wall on a plain hides what lies below the line over its top", "[raytracer][analyse]") {
    constexpr int kWall = 20;  // from there to 22
    ArrayWorld world({0, -1, -8}, {400, 10, 8});
    world.fill({0, -1, -8}, {400, 0, 8}, Material::kGrass);
    world.fill({kWall, 0, -8}, {kWall + 2, 10, 8}, Material::kWall);
    struct Case {
        double eye;
        double target;
    };
    for (const Case& c : {Case{12, 0}, Case{12, 2}, Case{30, 0}, Case{10.5, 9}}) {
        INFO("eye " << c.eye << ", target " << c.target);
        const Measured raster(world, sight_scene({{0.5, c.eye, -0.5}}, c.target), one_row(0, 400));
        // Similar triangles over the far edge of the wall's top.
        const double hidden_to = (kWall + 2 - 0.5) * (c.eye - c.target) / (c.eye - 10) + 0.5;
        for (int x = 0; x < 400; ++x) {
            INFO("cell " << x);
            const double middle = x + 0.5;
            if (std::abs(middle - hidden_to) < 0.51)
                continue;
            const bool is_hidden = x >= kWall + 2 && middle < hidden_to;
            CHECK(raster.at(x, -1, "seen") == (is_hidden ? 0.0F : 1.0F));
        }
    }
}

TEST_CASE("over a flat sea a sail vanishes where the horizons of mast and eye meet",
          "[raytracer][analyse]") {
    constexpr double kVoxel_m = 4;
    constexpr int kLength = 8000;
    constexpr double kEye_m = 20;
    constexpr double kSail_m = 10;
    constexpr double kEarth_m = 6371008.8;
    ArrayWorld world({0, -1, -2}, {kLength, 0, 2});
    world.fill({0, -1, -2}, {kLength, 0, 2}, Material::kWater);
    world.editable_info().voxel_m = kVoxel_m;
    scene::Scene scene = sight_scene({{0.5, kEye_m / kVoxel_m, -0.5}}, kSail_m);
    scene.analysis.curvature = true;
    Measured::Options options = one_row(0, kLength);
    options.area->min[1] = -1;
    options.area->max[1] = 0;
    options.edge_m = kVoxel_m;
    for (const double refraction : {0.0, 0.13, 0.25}) {
        INFO("refraction " << refraction);
        scene.analysis.refraction = refraction;
        const Measured raster(world, scene, options);
        const double radius_m = kEarth_m / (1 - refraction);
        const double vanishes_m =
            std::sqrt(2 * radius_m * kEye_m) + std::sqrt(2 * radius_m * kSail_m);
        int last = 0;
        for (int x = 0; x < kLength; ++x)
            if (raster.at(x, -1, "seen") > 0) {
                CHECK(x - last <= 1);
                last = x;
            }
        if (vanishes_m < kLength * kVoxel_m)
            CHECK(std::abs(last * kVoxel_m - vanishes_m) < 0.001 * vanishes_m);
        else
            CHECK(last == kLength - 1);
    }
    scene.analysis.curvature = false;
    const Measured flat(world, scene, options);
    CHECK(flat.at(kLength - 1, -1, "seen") == 1);
}

TEST_CASE("who sees is seen", "[raytracer][analyse]") {
    for (const unsigned seed : {1U, 2U}) {
        INFO("seed " << seed);
        const auto world = random_blocks(seed);
        constexpr double kHeight = 1.5;
        // Where a person in the middle of a cell has the eyes, as the evaluator places the target.
        std::vector<Point> eyes;
        std::mt19937 random(seed);
        while (eyes.size() < 24) {
            const int x = static_cast<int>(random() % 48) - 24;
            const int z = static_cast<int>(random() % 48) - 24;
            int top = 11;
            while (world->at(x, top, z) == Material::kAir)
                --top;
            eyes.push_back({x + 0.5, top + 1 + kHeight, z + 0.5});
        }
        const auto find_cell = [](double v) { return static_cast<int>(std::floor(v)); };
        std::vector<Measured> rasters;
        rasters.reserve(eyes.size());
        for (const Point& eye : eyes) {
            scene::Scene scene = sight_scene({eye}, kHeight);
            scene.analysis.curvature = true;
            rasters.emplace_back(*world, scene, Measured::Options{});
        }
        int seen = 0;
        for (std::size_t i = 0; i < eyes.size(); ++i)
            for (std::size_t j = 0; j < i; ++j) {
                const float there =
                    rasters[i].at(find_cell(eyes[j][0]), find_cell(eyes[j][2]), "seen");
                const float back =
                    rasters[j].at(find_cell(eyes[i][0]), find_cell(eyes[i][2]), "seen");
                CHECK(there == back);
                seen += there > 0 ? 1 : 0;
            }
        CHECK(seen > 20);
        CHECK(seen < 250);
    }
}

TEST_CASE("several observers add up, and the nearest gives the distance", "[raytracer][analyse]") {
    const auto world = random_blocks(5);
    const Point one{-20.25, 9, 3.5};
    const Point other{15.5, 11.5, -20.5};
    const Measured first(*world, sight_scene({one}), {});
    const Measured second(*world, sight_scene({other}), {});
    const Measured both(*world, sight_scene({one, other}), {});
    for (int z = -24; z < 24; ++z)
        for (int x = -24; x < 24; ++x) {
            const float a = first.at(x, z, "seen");
            const float b = second.at(x, z, "seen");
            CHECK(both.at(x, z, "seen") == a + b);
            const float near_a = first.at(x, z, "distance_m");
            const float near_b = second.at(x, z, "distance_m");
            const float expected = a > 0 && b > 0 ? std::min(near_a, near_b)
                                   : a > 0        ? near_a
                                                  : near_b;
            CHECK(both.at(x, z, "distance_m") == expected);
        }
}

TEST_CASE("what is seen below a deck is seen on the ground", "[raytracer][analyse]") {
    ArrayWorld world({-20, -1, -4}, {20, 8, 4});
    world.fill({-20, -1, -4}, {20, 0, 4}, Material::kGrass);
    world.fill({0, 5, -4}, {10, 6, 4}, Material::kBridge);
    scene::Scene scene = sight_scene({{-15.5, 1.5, 0.5}});
    const Measured top(world, scene, {});
    CHECK(top.at(5, 0, "seen") == 0);
    CHECK(top.at(5, 0, "material") == static_cast<float>(Material::kBridge));
    scene.analysis.surface = core::AnalysisSurface::kGround;
    const Measured ground(world, scene, {});
    CHECK(ground.at(5, 0, "seen") == 1);
    CHECK(ground.at(5, 0, "material") == static_cast<float>(Material::kGrass));
}

TEST_CASE("cells beyond the range are not seen", "[raytracer][analyse]") {
    ArrayWorld world({0, -1, -8}, {100, 1, 8});
    world.fill({0, -1, -8}, {100, 0, 8}, Material::kGrass);
    scene::Scene scene = sight_scene({{0.5, 3, -0.5}});
    scene.analysis.range_m = 40;
    const Measured raster(world, scene, one_row(0, 100));
    CHECK(raster.at(40, -1, "seen") == 1);
    CHECK(raster.at(41, -1, "seen") == 0);
    CHECK(raster.at(41, -1, "distance_m") == core::kNoData);
}

TEST_CASE("a line of sight through a hole has no value", "[raytracer][analyse]") {
    ArrayWorld world({0, -1, 0}, {192, 20, 64});
    world.fill({0, -1, 0}, {192, 0, 64}, Material::kGrass);
    world.make_hole({0, 1, 0, 0});
    const Measured raster(world, sight_scene({{10.5, 5, 30.5}}), {});
    CHECK(raster.at(20, 30, "seen") == 1);
    CHECK(raster.at(100, 30, "seen") == core::kNoData);
    CHECK(raster.at(100, 30, "hole") == 1);
    CHECK(raster.at(150, 30, "seen") == core::kNoData);
    CHECK(raster.at(150, 30, "hole") == 1);
}

TEST_CASE("observers are placed on tops, on the ground, and where they may be",
          "[raytracer][analyse]") {
    ArrayWorld world({-20, -1, -4}, {20, 8, 4});
    world.fill({-20, -1, -4}, {20, 0, 4}, Material::kGrass);
    world.fill({0, 5, -4}, {10, 6, 4}, Material::kBridge);
    world.fill({-10, 0, -4}, {-5, 6, 4}, Material::kWall);
    world.fill({15, -1, -4}, {20, 0, 4}, Material::kAir);
    world.make_hole({0, 0, 0, -1});
    blocks::BlockManager blocks(world, std::size_t{64} << 20);
    scene::Scene scene = sight_scene({});
    const analyse::CellGrid grid = analyse::grid_over(world.info(), world.info().bounds, 1);
    analyse::look_at_cells(grid, world.info(), scene);
    const auto place = [&](double x, double z, double height, analyse::HeightBase base) {
        const analyse::Observer observer{x, z, height, base, "here"};
        return analyse::place_observers({&observer, 1}, scene, blocks).points.at(0)[1];
    };
    using analyse::HeightBase;
    CHECK(place(5.5, 1.5, 1.5, HeightBase::kTop) == 7.5);
    CHECK(place(5.5, 1.5, 1.5, HeightBase::kGround) == 1.5);
    CHECK(place(5.5, 1.5, 2.25, HeightBase::kZero) == 2.25);
    CHECK(place(-7.5, 1.5, 3, HeightBase::kTop) == 9);
    CHECK(place(17.5, 1.5, 3, HeightBase::kZero) == 3);
    const auto refusal = [&](double x, double z, double height, HeightBase base) {
        try {
            (void)place(x, z, height, base);
        } catch (const util::Error& e) {
            return (e.exit_code() == util::ExitCode::kUsage ? "usage: " : "failed: ") +
                   std::string(e.what());
        }
        return std::string("none");
    };
    CHECK(refusal(-7.5, 1.5, 1, HeightBase::kZero) ==
          "usage: place the observer here: at 1 m it lies inside of something solid; allowed: "
          "6 m and more, the top there");
    CHECK_THAT(refusal(-7.5, 1.5, 1, HeightBase::kGround),
               test::contains("inside of what is 6 m high"));
    CHECK_THAT(refusal(-15.5, 1.5, -2, HeightBase::kZero),
               test::contains("at -2 m it lies below the ground; allowed: 0 m and more"));
    CHECK_THAT(refusal(17.5, 1.5, 1, HeightBase::kTop), test::contains("no data at that place"));
    CHECK_THAT(refusal(20.5, 1.5, 1, HeightBase::kZero),
               test::contains("outside of the data; allowed: x -20 to 20, z -4 to 4"));
    CHECK_THAT(refusal(5.5, -1.5, 1, HeightBase::kTop), test::contains("failed: "));
}
