#include <cmath>
#include <memory>
#include <utility>

#include "raytracer/core/shade/view.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/analyse/evaluators/measured.hpp"
#include "tests/raytracer/landscape.hpp"

namespace {

using namespace terravox;
using test::ArrayWorld;
using voxel::Material;

/// A meadow with a wall from west to east along its southern border.
std::unique_ptr<ArrayWorld> meadow_with_wall() {
    constexpr int kSize = 32;
    constexpr int kHeight = 12;
    auto world = std::make_unique<ArrayWorld>(ArrayWorld::Coord{0, 0, 0},
                                              ArrayWorld::Coord{kSize, kHeight, kSize});
    world->fill({0, 0, 0}, {kSize, 1, kSize}, Material::kGrass);
    world->fill({0, 0, kSize - 2}, {kSize, kHeight, kSize}, Material::kWall);
    world->editable_info().centre = geo::MapPlace{46, 14.5};
    return world;
}

scene::Scene day(core::AnalysisKind kind) {
    scene::Scene scene = test::analysis_scene(kind);
    scene.sun.date = "2026-10-10";
    scene.sun.utc_offset_h = 1;
    scene.analysis.step_min = 10;
    return scene;
}

TEST_CASE("a camera sees the hours of sun that a raster has") {
    const test::Measured cells(*meadow_with_wall(), day(core::AnalysisKind::kSun), {});
    // The same cells as pixels of a camera.
    scene::Scene scene = day(core::AnalysisKind::kSunView);
    auto world = meadow_with_wall();
    const auto grid = analyse::grid_over(world->info(), world->info().bounds, 1);
    analyse::look_at_cells(grid, world->info(), scene);
    scene.quality.samples = 64;
    test::Job job(scene, std::size_t{256} << 20, std::move(world), analyse::measure);
    const output::Film film = test::render_scene(job, 2);
    const double day_h = analyse::day_hours(job.view);
    double least = 24;
    double most = 0;
    for (int z = 0; z < 30; z += 3)
        for (int x = 1; x < 32; x += 5) {
            CAPTURE(x, z);
            const double expected = static_cast<double>(cells.at(x, z, "sun_hours"));
            // The samples of a pixel are strewn over the cell, of which the raster takes the
            // middle.
            CHECK(static_cast<double>(film.at(x, z).colour.r) * day_h ==
                  Approx(expected).margin(0.5));
            CHECK(film.at(x, z).colour.g == 0);
            CHECK(film.at(x, z).alpha == 1);
            least = std::min(least, expected);
            most = std::max(most, expected);
        }
    CHECK(most - least > 4);
}

TEST_CASE("walls are in the sun on their own side alone") {
    scene::Scene scene = day(core::AnalysisKind::kSunView);
    auto world = meadow_with_wall();
    scene.camera = {};
    scene.camera.space = core::CoordinateSpace::kVoxel;
    scene.camera.position = {16, 6, -20};
    scene.camera.target = {16, 6, 30};
    scene.output.size_px = {33, 33};
    scene.quality.samples = 4;
    test::Job north(scene, std::size_t{256} << 20, std::move(world), analyse::measure);
    // In October the sun is always in the south.
    CHECK(test::render_scene(north, 1).at(16, 16).colour.r == 0);
    scene.camera.position = {16, 6, 80};
    test::Job south(scene, std::size_t{256} << 20, meadow_with_wall(), analyse::measure);
    CHECK(test::render_scene(south, 1).at(16, 16).colour.r > 0.9F);
}

}  // namespace
