#include "raytracer/analyse/raster/cell_grid.hpp"

#include "common/geo/crs.hpp"
#include "common/util/error.hpp"
#include "raytracer/core/scene/camera.hpp"
#include "raytracer/core/scene/scene_io.hpp"
#include "tests/catch.hpp"

namespace {

using namespace terravox;

voxel::WorldInfo make_world(double voxel_m) {
    voxel::WorldInfo world;
    world.bounds = {{-7, 0, -13}, {23, 40, 5}};
    world.voxel_m = voxel_m;
    world.crs = "EPSG:3794";
    world.crs_units_per_voxel = voxel_m;
    return world;
}

}  // namespace

TEST_CASE("cells cover the area, and begin at multiples of their edge", "[raytracer][analyse]") {
    const voxel::WorldInfo world = make_world(0.5);
    const analyse::CellGrid grid = analyse::grid_over(world, world.bounds, 2);
    CHECK(grid.edge_voxels == 4);
    CHECK(grid.west == -2);
    CHECK(grid.columns == 8);
    CHECK(grid.north == -4);
    CHECK(grid.rows == 6);
    const auto place = analyse::make_placement(grid, world).transform;
    CHECK(place == std::array<double, 6>{-4, 2, 0, 8, 0, -2});
    CHECK(analyse::grid_over(world, world.bounds, {}).edge_m == 0.5);
}

TEST_CASE("in a wide world the sun is that of the square of 10 km around the raster's middle",
          "[raytracer][analyse]") {
    voxel::WorldInfo world = make_world(2);
    world.bounds = {{220'000, 0, -60'000}, {250'000, 100, -40'000}};
    world.crs_wkt = geo::Crs::from_text("EPSG:3794").wkt();
    world.centre = geo::map_place(geo::Crs::from_text("EPSG:3794"), 470'000, 100'000);
    const auto place_at = [&](int x, int z) {
        const analyse::CellGrid grid =
            analyse::grid_over(world, {{x, 0, z}, {x + 100, 100, z + 100}}, 2);
        scene::Scene scene;
        scene.analysis.kind = core::AnalysisKind::kTerrain;
        analyse::look_at_cells(grid, world, scene);
        CHECK_FALSE(scene.analysis.place);  // it has no sun
        scene.analysis.kind = core::AnalysisKind::kSun;
        analyse::look_at_cells(grid, world, scene);
        return scene.analysis.place;
    };
    const auto west = place_at(221'000, -51'000);
    REQUIRE(west);
    // The square from 440 to 450 km east and from 100 to 110 km north.
    const geo::MapPlace expected =
        geo::map_place(geo::Crs::from_text("EPSG:3794"), 445'000, 105'000);
    CHECK((*west)[0] == expected.lat_deg);
    CHECK((*west)[1] == expected.lon_deg);
    CHECK((*west)[2] == expected.convergence_deg);
    CHECK(place_at(224'500, -54'000) == west);
    CHECK(place_at(226'000, -51'000) != west);
    world.bounds.max[0] = world.bounds.min[0] + 10'000;
    world.bounds.max[2] = world.bounds.min[2] + 10'000;
    CHECK_FALSE(place_at(221'000, -51'000));
}

TEST_CASE("the grid is found again from the scene, though that was a text",
          "[raytracer][analyse]") {
    for (const double voxel_m : {0.25, 1.0, 0.3048})
        for (const double times : {1.0, 1.7, 3.0, 7.3}) {
            const voxel::WorldInfo world = make_world(voxel_m);
            const analyse::CellGrid grid = analyse::grid_over(world, world.bounds, voxel_m * times);
            scene::Scene scene;
            analyse::look_at_cells(grid, world, scene);
            scene::Scene read;
            scene::parse_scene(scene::to_toml(scene), "of a test", read);
            const analyse::CellGrid found = analyse::make_grid(read, world);
            CAPTURE(voxel_m, times);
            CHECK(found.west == grid.west);
            CHECK(found.north == grid.north);
            CHECK(found.columns == grid.columns);
            CHECK(found.rows == grid.rows);
            CHECK(found.edge_m == grid.edge_m);
            CHECK(analyse::make_placement(found, world).transform ==
                  analyse::make_placement(grid, world).transform);
        }
}

TEST_CASE("a scene that looks at no cells has no grid", "[raytracer][analyse]") {
    const voxel::WorldInfo world = make_world(1);
    scene::Scene scene;
    CHECK_THROWS_AS(analyse::make_grid(scene, world), util::Error);
    scene.analysis.cell_m = 1;
    CHECK_THROWS_AS(analyse::make_grid(scene, world), util::Error);
    scene.camera.target = {1e300, 0, 0};
    CHECK_THROWS_AS(analyse::make_grid(scene, world), util::Error);
    scene.camera.target = {0, 0, 0};
    CHECK(analyse::make_grid(scene, world).columns == scene.output.size_px[0]);
}

TEST_CASE("cells smaller than voxels, and too many, are refused", "[raytracer][analyse]") {
    const voxel::WorldInfo world = make_world(1);
    for (const double edge_m : {0.5, 0.0, -1.0, 1e6})
        CHECK_THROWS_AS(analyse::grid_over(world, world.bounds, edge_m), util::UsageError);
    voxel::WorldInfo wide = world;
    wide.bounds.max[0] = 70'000;
    CHECK_THROWS_AS(analyse::grid_over(wide, wide.bounds, 1), util::UsageError);
    CHECK(analyse::grid_over(wide, wide.bounds, 2).columns == 35'004);
}
