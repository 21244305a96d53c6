#include <cmath>

#include "common/geo/sun_position.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/analyse/evaluators/measured.hpp"

namespace {

using namespace terravox;
using core::AnalysisKind;
using test::ArrayWorld;
using test::Measured;
using voxel::Material;

constexpr geo::MapPlace kPlace{46, 14.5};
constexpr double kOffset_h = 1;

scene::Scene sun_scene(const char* date, double step_min) {
    scene::Scene scene = test::analysis_scene(core::AnalysisKind::kSun);
    scene.sun.date = date;
    scene.sun.utc_offset_h = kOffset_h;
    scene.analysis.step_min = step_min;
    return scene;
}

scene::Scene period_scene(AnalysisKind kind, const char* from, const char* to, double bin_deg) {
    scene::Scene scene = test::analysis_scene(kind);
    scene.sun.utc_offset_h = kOffset_h;
    scene.analysis.from = from;
    scene.analysis.to = to;
    scene.analysis.step_min = 30;
    scene.analysis.bin_deg = bin_deg;
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
    constexpr double kRadPerDeg = det::kPi / 180;
    constexpr double kHeight = 10;
    Hours out;
    for (double begin = 0; begin < 24; begin += step_min / 60) {
        const double middle = begin + step_min / 120;
        const geo::SunPosition sun = geo::sun_position({2026, month, day, middle, kOffset_h},
                                                       kPlace, geo::SunPrecision::kAnalysis);
        if (sun.altitude_deg <= 0)
            continue;
        const double south =
            -std::cos(sun.azimuth_deg * kRadPerDeg) * std::cos(sun.altitude_deg * kRadPerDeg);
        const double up = std::sin(sun.altitude_deg * kRadPerDeg);
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
            CHECK(std::abs(static_cast<double>(raster.at(0, cell, "sun_hours")) - hours.sunlit) <
                  0.01);
            CHECK(std::abs(static_cast<double>(raster.at(0, cell, "first_sun")) - hours.first) <
                  0.01);
            CHECK(std::abs(static_cast<double>(raster.at(0, cell, "last_sun")) - hours.last) <
                  0.01);
        }
    }
}

TEST_CASE("hours of a period are the sum of those of its days, and those of its months",
          "[raytracer][analyse]") {
    const auto world = wall();
    Measured::Options options;
    options.area = voxel::VoxelBounds{{0, -1, -64}, {1, 0, 0}};
    const char* from = "2026-02-25";
    const char* to = "2026-03-04";
    const Measured period(*world, period_scene(AnalysisKind::kSunPeriod, from, to, 0), options);
    const Measured months(*world, period_scene(AnalysisKind::kSunMonths, from, to, 0), options);
    for (const int cell : {-60, -20, -4, -1}) {
        INFO("cell " << cell);
        double february = 0;
        double march = 0;
        double possible = 0;
        for (int day = 25; day < 33; ++day) {
            const int month = day > 28 ? 3 : 2;
            const int of_month = day > 28 ? day - 28 : day;
            (month == 3 ? march : february) += expected(month, of_month, 30, -(cell + 0.5)).sunlit;
            possible += expected(month, of_month, 30, 1e9).sunlit;
        }
        const double hours = february + march;
        const auto at = [&](const Measured& from_raster, auto band) {
            return static_cast<double>(from_raster.at(0, cell, band));
        };
        CHECK(at(period, "sun_hours") == Approx(hours).margin(0.01));
        CHECK(at(period, "sun_hours_per_day") == Approx(hours / 8).margin(0.01));
        CHECK(at(period, "sun_share") == Approx(hours / possible).margin(0.001));
        CHECK(at(months, "sun_hours") == Approx(hours).margin(0.01));
        CHECK(at(months, "january") == 0);
        CHECK(at(months, "february") == Approx(february).margin(0.01));
        CHECK(at(months, "march") == Approx(march).margin(0.01));
        CHECK(at(months, "hole") == 0);
    }
}

TEST_CASE("hours of a year by bins are within a hundredth of those by each step",
          "[raytracer][analyse][all]") {
    ArrayWorld world({-30, -1, -30}, {30, 20, 30});
    world.fill({-30, -1, -30}, {30, 0, 30}, Material::kGrass);
    world.fill({-4, 0, -4}, {5, 20, 5}, Material::kWall);
    world.fill({12, 0, -20}, {14, 9, 20}, Material::kWall);
    world.fill({-20, 0, -24}, {-16, 14, 2}, Material::kWall);
    world.editable_info().centre = kPlace;
    const auto year = [&](double bin_deg) {
        return Measured(world,
                        period_scene(AnalysisKind::kSunPeriod, "2026-01-01", "2026-12-31", bin_deg),
                        {2, 16});
    };
    const Measured each = year(0);
    const Measured binned = year(3);
    double square = 0;
    double mean = 0;
    constexpr int kCells = 60 * 60;
    for (int z = -30; z < 30; ++z)
        for (int x = -30; x < 30; ++x) {
            const auto hours = static_cast<double>(each.at(x, z, "sun_hours"));
            const double error = static_cast<double>(binned.at(x, z, "sun_hours")) - hours;
            mean += hours / kCells;
            square += error * error / kCells;
        }
    INFO("error " << std::sqrt(square) << " of " << mean << " hours");
    CHECK(mean > 2000);
    CHECK(std::sqrt(square) < 0.01 * mean);
}

TEST_CASE("at an instant a wall's shadow is as long as its height says", "[raytracer][analyse]") {
    const auto world = wall();
    Measured::Options options;
    options.area = voxel::VoxelBounds{{0, -1, -64}, {1, 0, 0}};
    scene::Scene scene = test::analysis_scene(AnalysisKind::kShadow);
    scene.sun.utc_offset_h = kOffset_h;
    scene.sun.date = "2026-10-10";
    scene.sun.time_h = 11;
    const geo::SunPosition sun =
        geo::sun_position({2026, 10, 10, 11, kOffset_h}, kPlace, geo::SunPrecision::kAnalysis);
    constexpr double kRad = det::kPi / 180;
    const double length =
        10 / std::tan(sun.altitude_deg * kRad) * -std::cos(sun.azimuth_deg * kRad);
    REQUIRE(length > 5);
    REQUIRE(length < 60);
    const Measured day(*world, scene, options);
    for (int cell = -64; cell < 0; ++cell) {
        INFO("cell " << cell);
        CHECK((day.at(0, cell, "sunlit") == 1) == (-(cell + 0.5) > length));
        CHECK(day.at(0, cell, "hole") == 0);
    }
    scene.sun.time_h = 1;
    CHECK(Measured(*world, scene, options).at(0, -60, "sunlit") == 0);
}
