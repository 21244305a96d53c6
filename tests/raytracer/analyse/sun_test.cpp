#include <cmath>

#include "common/geo/sun_position.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/analyse/measured.hpp"

namespace {

using namespace terravox;
using core::SunBand;
using test::ArrayWorld;
using test::Measured;
using voxel::Material;

constexpr geo::LatLon kPlace{46, 14.5};
constexpr double kOffset_h = 1;

scene::Scene sun_scene(const char* date, double step_min) {
    scene::Scene scene = test::analysis_scene(core::AnalysisKind::kSun);
    scene.sun.date = date;
    scene.sun.utc_offset_h = kOffset_h;
    scene.analysis.step_min = step_min;
    return scene;
}

/// A plane with a wall of height 10 that runs from west to east: its north face is at z = 0.
std::unique_ptr<ArrayWorld> wall() {
    constexpr int kLength = 2000;
    auto world = std::make_unique<ArrayWorld>(ArrayWorld::Coord{-kLength, -1, -64},
                                              ArrayWorld::Coord{kLength, 10, 4});
    world->fill({-kLength, -1, -64}, {kLength, 0, 4}, Material::kGrass);
    world->fill({-kLength, 0, 0}, {kLength, 10, 4}, Material::kWall);
    world->editable_info().centre = kPlace;
    return world;
}

struct Hours {
    double sunlit = 0;
    double first = core::kNoData;
    double last = core::kNoData;
};

/// What a point north of the endless wall gets on a day.
/// @param distance from the wall, metres
Hours expected(int month, int day, double step_min, double distance) {
    constexpr double kRad = det::kPi / 180;
    constexpr double kHeight = 10;
    Hours out;
    for (double begin = 0; begin < 24; begin += step_min / 60) {
        const double middle = begin + step_min / 120;
        const geo::SunPosition sun =
            geo::sun_position({2026, month, day, middle, kOffset_h}, kPlace);
        if (sun.altitude_deg <= 0)
            continue;
        const double south = -std::cos(sun.azimuth_deg * kRad) * std::cos(sun.altitude_deg * kRad);
        const double up = std::sin(sun.altitude_deg * kRad);
        if (south > 0 && distance / south * up < kHeight)
            continue;
        out.sunlit += step_min / 60;
        out.first = out.sunlit * 60 < step_min * 1.5 ? begin : out.first;
        out.last = begin + step_min / 60;
    }
    return out;
}

}  // namespace

TEST_CASE("hours of sun north of a long wall are those of the sun's way", "[raytracer][analyse]") {
    struct Day {
        const char* date;
        int month;
        int day;
        double step_min;
    };
    const Day days[] = {
        {"2026-06-21", 6, 21, 15}, {"2026-12-21", 12, 21, 10}, {"2026-03-20", 3, 20, 5}};
    const auto world = wall();
    for (const Day& d : days) {
        INFO(d.date);
        Measured::Options options;
        options.area = voxel::VoxelBounds{{0, -1, -64}, {1, 0, 0}};
        const Measured raster(*world, sun_scene(d.date, d.step_min), options);
        for (const int cell : {-60, -30, -20, -10, -4, -1}) {
            INFO("cell " << cell);
            const Hours hours = expected(d.month, d.day, d.step_min, -(cell + 0.5));
            CHECK(std::abs(static_cast<double>(raster.at(0, cell, SunBand::kHours)) -
                           hours.sunlit) < 0.01);
            CHECK(std::abs(static_cast<double>(raster.at(0, cell, SunBand::kFirst)) - hours.first) <
                  0.01);
            CHECK(std::abs(static_cast<double>(raster.at(0, cell, SunBand::kLast)) - hours.last) <
                  0.01);
        }
    }
}

TEST_CASE("what lies in shadow all day has no hours, and no first sun", "[raytracer][analyse]") {
    ArrayWorld world({-30, -1, -30}, {30, 20, 30});
    world.fill({-30, -1, -30}, {30, 0, 30}, Material::kGrass);
    world.fill({-4, 0, -4}, {5, 20, 5}, Material::kWall);
    world.fill({0, 0, 0}, {1, 20, 1}, Material::kAir);
    world.editable_info().centre = kPlace;
    const Measured raster(world, sun_scene("2026-12-21", 20), {});
    CHECK(raster.at(0, 0, SunBand::kHours) == 0);
    CHECK(raster.at(0, 0, SunBand::kFirst) == core::kNoData);
    CHECK(raster.at(0, 0, SunBand::kLast) == core::kNoData);
    CHECK(raster.at(2, 2, SunBand::kHours) > 8);
}

TEST_CASE("hours of sun are the same for any tile size and number of threads",
          "[raytracer][analyse]") {
    ArrayWorld world({-30, -1, -30}, {30, 20, 30});
    world.fill({-30, -1, -30}, {30, 0, 30}, Material::kGrass);
    world.fill({-4, 0, -4}, {5, 20, 5}, Material::kWall);
    world.editable_info().centre = kPlace;
    const scene::Scene scene = sun_scene("2026-09-01", 30);
    const Measured plain(world, scene, {});
    CHECK(Measured(world, scene, {3, 7}).values() == plain.values());
    CHECK(Measured(world, scene, {2, 64}).values() == plain.values());
}
