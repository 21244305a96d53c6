#include "raytracer/farm/wire/picture_spec.hpp"

#include "raytracer/analyse/solar/sun_way.hpp"
#include "tests/catch.hpp"

using namespace terravox;

namespace {

voxel::WorldInfo place() {
    voxel::WorldInfo world;
    world.title = "place";
    world.bounds = {{0, 0, 0}, {64, 64, 64}};
    world.levels = 1;
    world.centre = geo::MapPlace{{46.05, 14.5}, -0.36};
    return world;
}

}  // namespace

TEST_CASE("workers see the sun of an analysis where the coordinator sees it", "[raytracer][farm]") {
    const voxel::WorldInfo world = place();
    for (const auto kind : {core::AnalysisKind::kShadow, core::AnalysisKind::kSun}) {
        for (const double time_h : {5.5, 9.25, 12.0, 18.75}) {
            INFO("at " << time_h);
            scene::Scene scene;
            scene.analysis.kind = kind;
            scene.sun.date = "2026-06-21";
            scene.sun.zone = "Europe/Ljubljana";
            scene.sun.time_h = time_h;
            const scene::Scene sent = farm::unpack_scene(farm::pack(scene, world).scene);
            const auto here = solar::make_sun_way(scene, &*world.centre).directions;
            const auto there = solar::make_sun_way(sent, &*world.centre).directions;
            REQUIRE(here.size() == there.size());
            for (std::size_t i = 0; i < here.size(); ++i)
                CHECK(here[i].to == there[i].to);
        }
    }
}
