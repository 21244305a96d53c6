#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "common/geo/crs.hpp"
#include "common/util/error.hpp"
#include "raytracer/analyse/horizon/horizon_maker.hpp"
#include "raytracer/analyse/solar/far_horizon.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/raytracer/analyse/evaluators/measured.hpp"
#include "tests/voxelserver/make/worlds/heightmap/raster_files.hpp"

namespace {

using namespace terravox;
using solar::FarHorizon;
using solar::FarTop;
using test::ArrayWorld;
using test::Measured;
using voxel::Material;

core::Vec3 towards(double azimuth_deg, double slope) {
    const double azimuth = azimuth_deg * (det::kPi / 180);
    return core::normalized({std::sin(azimuth), slope, -std::cos(azimuth)});
}

FarHorizon same_all_around(const FarHorizon::Lattice& lattice, const FarHorizon::Tops& tops,
                           double voxel_m = 1) {
    return {lattice, std::vector(lattice.points() * FarHorizon::kAzimuths, tops), voxel_m};
}

/// A meadow at the height 0 of Slovenia's map, 40 m wide.
std::unique_ptr<ArrayWorld> meadow() {
    constexpr int kEast = 460'000;
    constexpr int kSouth = -101'000;
    constexpr int kWidth = 40;
    auto world = std::make_unique<ArrayWorld>(ArrayWorld::Coord{kEast, -1, kSouth - kWidth},
                                              ArrayWorld::Coord{kEast + kWidth, 0, kSouth});
    world->fill({kEast, -1, kSouth - kWidth}, {kEast + kWidth, 0, kSouth}, Material::kGrass);
    world->editable_info().centre = geo::MapPlace{46, 14.5};
    world->editable_info().crs = "EPSG:3794";
    world->editable_info().crs_wkt = geo::Crs::from_text("EPSG:3794").wkt();
    return world;
}

/// A raster of heights in cells of 20 m, 10 km around the meadow.
std::filesystem::path heights_around(const test::TemporaryFolder& folder,
                                     const std::function<double(double, double)>& height) {
    constexpr int kCells = 1000;
    constexpr double kCell_m = 20;
    constexpr double kHalf_m = kCells / 2.0 * kCell_m;
    test::RasterSpec spec;
    spec.width = kCells;
    spec.height = kCells;
    spec.geo = {460'020 - kHalf_m, kCell_m, 0, 101'020 + kHalf_m, 0, -kCell_m};
    return test::write_heights(folder.path() / "around.tif", spec, [&](int column, int row) {
        return height((column + 0.5) * kCell_m - kHalf_m, kHalf_m - (row + 0.5) * kCell_m);
    });
}

TEST_CASE("a top hides what is below the line to it") {
    const FarTop top{1000, 500};
    const FarHorizon horizon = same_all_around({3, 2, 0, 0, 100, 50}, {top}, 0.5);
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> any(0, 1);
    int hidden = 0;
    constexpr int kRays = 2000;
    for (int i = 0; i < kRays; ++i) {
        const double height_m = any(random) * 600;
        const double slope = any(random);
        const core::Vec3 from{any(random) * 200 - 50, height_m / 0.5, any(random) * 200 - 50};
        const bool is_hidden = height_m + slope * top.distance_m < top.height_m;
        CAPTURE(height_m, slope);
        CHECK(horizon.hides(from, towards(any(random) * 360, slope)) == is_hidden);
        hidden += is_hidden ? 1 : 0;
    }
    CHECK(hidden > kRays / 10);
    CHECK_FALSE(horizon.hides({}, {0, 1, 0}));
}

TEST_CASE("shadow heights are interpolated between points and azimuths") {
    // The western point sees tops in the north and in the east, the eastern one sees none as high.
    FarHorizon::Lattice lattice{2, 1, 0, 0, 100, 0};
    std::vector<FarHorizon::Tops> tops(lattice.points() * FarHorizon::kAzimuths);
    std::fill_n(tops.begin(), FarHorizon::kAzimuths, FarHorizon::Tops{{1000, 200}});
    std::fill_n(tops.begin() + FarHorizon::kAzimuths, FarHorizon::kAzimuths,
                FarHorizon::Tops{{1000, 100}});
    tops[0] = {{1000, 400}};
    tops[90] = {{1000, 300}};
    const FarHorizon horizon(lattice, tops, 1);
    const auto shadow = [&](double x, double azimuth_deg) {
        double low = -100;
        double high = 1000;
        while (high - low > 1e-3) {
            const double middle = (low + high) / 2;
            (horizon.hides({x, middle, 0}, towards(azimuth_deg, 0)) ? low : high) = middle;
        }
        return low;
    };
    CHECK(shadow(0, 45) == Approx(200).margin(0.01));
    CHECK(shadow(50, 45) == Approx(150).margin(0.01));
    CHECK(shadow(100, 45) == Approx(100).margin(0.01));
    CHECK(shadow(500, 45) == Approx(100).margin(0.01));
    CHECK(shadow(0, 90) == Approx(300).margin(0.01));
    CHECK(shadow(0, 90.5) == Approx(250).margin(0.01));
    CHECK(shadow(0, 0) == Approx(400).margin(0.01));
    CHECK(shadow(0, 359.75) == Approx(350).margin(0.01));
}

TEST_CASE("a skyline keeps what some slope needs") {
    std::mt19937_64 random(2);
    std::uniform_real_distribution<double> any(0, 1);
    for (int run = 0; run < 50; ++run) {
        analyse::Skyline skyline;
        std::vector<FarTop> all;
        double distance_m = 10;
        for (int i = 0; i < 200; ++i) {
            distance_m = std::round(distance_m * 1.03 + 1);
            const double height_m = std::round(any(random) * any(random) * 1000);
            skyline.add(distance_m, height_m);
            all.push_back({static_cast<int>(distance_m), static_cast<int>(height_m)});
        }
        const FarHorizon::Tops tops = skyline.tops();
        REQUIRE(!tops.empty());
        CHECK(tops.size() <= FarHorizon::kMaxTops);
        const auto shadow_m = [](const std::vector<FarTop>& of, double slope) {
            double out = -1e9;
            for (const FarTop& top : of)
                out = std::max(out, top.height_m - slope * top.distance_m);
            return out;
        };
        for (double slope = 0; slope < 4; slope += 0.05) {
            CAPTURE(run, slope);
            CHECK(shadow_m(tops, slope) <= shadow_m(all, slope));
            CHECK(shadow_m(tops, slope) >= shadow_m(all, slope) - 6);
        }
    }
}

TEST_CASE("a horizon is the same from its text") {
    FarHorizon::Lattice lattice{2, 3, -10.5, 0, 1e6, 7};
    std::vector<FarHorizon::Tops> tops(lattice.points() * FarHorizon::kAzimuths);
    std::mt19937_64 random(3);
    for (FarHorizon::Tops& some : tops)
        for (int i = 0; i < static_cast<int>(random() % 5); ++i)
            some.push_back({100 * (i + 1) + static_cast<int>(random() % 100),
                            200 * i + static_cast<int>(random() % 200)});
    const std::string text = solar::to_text(lattice, tops);
    const FarHorizon from_text = solar::parse_far_horizon(text, 2);
    const FarHorizon horizon(lattice, tops, 2);
    std::uniform_real_distribution<double> any(0, 1);
    for (int i = 0; i < 2000; ++i) {
        const core::Vec3 from{any(random) * 1e6, any(random) * 500, any(random) * 10};
        const core::Vec3 to = towards(any(random) * 360, any(random) * 2);
        CHECK(horizon.hides(from, to) == from_text.hides(from, to));
    }
    CHECK(solar::parse_far_horizon("", 1).empty());
}

TEST_CASE("texts that are no horizon are refused") {
    const FarHorizon::Lattice lattice;
    const std::vector<FarHorizon::Tops> tops(FarHorizon::kAzimuths, {{10, 5}});
    const std::string good = solar::to_text(lattice, tops);
    REQUIRE_FALSE(solar::parse_far_horizon(good, 1).empty());
    const std::string head = "1,1;0,0;0,0;";
    std::string rest;
    for (int i = 1; i < FarHorizon::kAzimuths; ++i)
        rest += "10,5;";
    std::string many;
    for (int i = 0; i <= 16; ++i)
        many += std::to_string(i) + "," + std::to_string(i) + (i < 16 ? "," : ";");
    const auto with = [&](const std::string& tops_of_north) { return head + tops_of_north + rest; };
    REQUIRE_FALSE(solar::parse_far_horizon(with("1,2,3,4;"), 1).empty());
    REQUIRE_FALSE(solar::parse_far_horizon(with(";"), 1).empty());
    const std::pair<const char*, std::string> cases[] = {
        {"words", "mountains"},
        {"an end too early", good.substr(0, good.size() / 2)},
        {"more than there are points", good + "1,2;"},
        {"no points", "0,1;0,0;0,0;"},
        {"ten columns", "10,1;0,0;0,0;"},
        {"a corner that is no number", "1,1;nan,0;0,0;" + good.substr(head.size())},
        {"a corner too far away", "1,1;0,0;1e300,0;" + good.substr(head.size())},
        {"corners the wrong way round", "1,1;5,0;0,0;" + good.substr(head.size())},
        {"a top without a height", with("1;")},
        {"tops that come nearer", with("2,1,1,2;")},
        {"tops that fall", with("1,2,2,1;")},
        {"a top in the sky", with("1,20000;")},
        {"a top behind the Earth", with("2000000,5;")},
        {"a top behind the observer", with("-1,5;")},
        {"17 tops", with(many)},
    };
    for (const auto& [name, text] : cases) {
        CAPTURE(name);
        CHECK_THROWS_AS(solar::parse_far_horizon(text, 1), util::UsageError);
    }
}

TEST_CASE("a ring of hills hides the sky below its rim") {
    const test::TemporaryFolder folder;
    const auto world = meadow();
    constexpr double kRadius_m = 4000;
    constexpr double kRim_m = 2000;
    const auto file = heights_around(folder, [](double east, double north) {
        return std::hypot(east, north) > kRadius_m ? kRim_m : 0.0;
    });
    scene::Scene scene = test::analysis_scene(core::AnalysisKind::kSky);
    const Measured open(*world, scene, {});
    analyse::look_at_horizon({file}, world->info(), scene);
    CHECK(scene.analysis.horizon.size() < 100'000);
    const Measured within(*world, scene, {});
    const int x = world->info().bounds.min[0] + 20;
    const int z = world->info().bounds.min[2] + 20;
    CHECK(open.at(x, z, "svf") == Approx(1).margin(1e-3));
    const double slope = kRim_m / kRadius_m;
    const double expected = 1 / (1 + slope * slope);
    CHECK(within.at(x, z, "svf") == Approx(expected).margin(0.01));
}

TEST_CASE("a ridge takes the sun of those in its shadow alone") {
    const test::TemporaryFolder folder;
    const auto world = meadow();
    constexpr double kNear_m = 3000;
    constexpr double kRidge_m = 1500;
    const auto file = heights_around(folder, [](double /*east*/, double north) {
        return north < -kNear_m && north > -kNear_m - 500 ? kRidge_m : 0.0;
    });
    scene::Scene scene = test::analysis_scene(core::AnalysisKind::kSun);
    scene.sun.utc_offset_h = 1;
    scene.sun.date = "2026-12-21";
    const auto hours = [&](const scene::Scene& of) {
        const Measured measured(*world, of, {});
        return static_cast<double>(measured.at(world->info().bounds.min[0] + 20,
                                               world->info().bounds.min[2] + 20, "sun_hours"));
    };
    const double free_h = hours(scene);
    scene::Scene behind = scene;
    analyse::look_at_horizon({file}, world->info(), behind);
    // The sun is 20.6 degrees high at noon, the ridge 26.6.
    CHECK(free_h > 8);
    CHECK(hours(behind) < 1);
    // In summer it is higher than the ridge.
    scene.sun.date = "2026-06-21";
    behind.sun.date = scene.sun.date;
    CHECK(hours(behind) == hours(scene));
    // Not seen from nearby, and not at all.
    scene.sun.date = "2026-12-21";
    analyse::look_at_horizon({file, 1000}, world->info(), scene);
    CHECK(hours(scene) == free_h);
}

TEST_CASE("heights in another system are the same horizon") {
    const test::TemporaryFolder folder;
    const auto world = meadow();
    const geo::Transform to_map(geo::Crs::from_text("EPSG:4326"), geo::Crs::from_text("EPSG:3794"));
    const auto ridge = [](double easting) { return easting > 463'000 ? 1000.0 : 0.0; };
    test::RasterSpec degrees;
    degrees.width = 600;
    degrees.height = 400;
    degrees.crs = "EPSG:4326";
    degrees.geo = {14.40, 0.0003, 0, 46.10, 0, -0.0003};
    const auto file =
        test::write_heights(folder.path() / "degrees.tif", degrees, [&](int x, int y) {
            double place[2] = {14.40 + (x + 0.5) * 0.0003, 46.10 - (y + 0.5) * 0.0003};
            to_map.apply({&place[0], 1}, {&place[1], 1});
            return ridge(place[0]);
        });
    scene::Scene scene = test::analysis_scene(core::AnalysisKind::kSky);
    analyse::look_at_horizon({file}, world->info(), scene);
    const FarHorizon horizon = solar::parse_far_horizon(scene.analysis.horizon, 1);
    const voxel::VoxelBounds& bounds = world->info().bounds;
    const core::Vec3 from{bounds.min[0] + 20.0, 0, bounds.min[2] + 20.0};
    const double slope = 1000.0 / (463'000 - from.x);
    CHECK(horizon.hides(from, towards(90, slope * 0.98)));
    CHECK_FALSE(horizon.hides(from, towards(90, slope * 1.02)));
    CHECK_FALSE(horizon.hides(from, towards(270, 0.01)));
}

TEST_CASE("rasters without heights outside of the data are refused") {
    const test::TemporaryFolder folder;
    auto world = meadow();
    scene::Scene scene = test::analysis_scene(core::AnalysisKind::kSky);
    const auto refused = [&](const std::filesystem::path& file, const std::string& why) {
        CAPTURE(file, why);
        CHECK_THROWS_WITH(analyse::look_at_horizon({file}, world->info(), scene),
                          test::contains(why));
        CHECK(scene.analysis.horizon.empty());
    };
    test::RasterSpec elsewhere;
    elsewhere.geo = {600'000, 1, 0, 101'080, 0, -1};
    const auto level = [](int, int) { return 5.0; };
    refused(test::write_heights(folder.path() / "elsewhere.tif", elsewhere, level), "no heights");
    test::RasterSpec within;
    within.width = 40;
    within.height = 40;
    within.geo = {460'000, 1, 0, 101'040, 0, -1};
    refused(test::write_heights(folder.path() / "within.tif", within, level),
            "outside of the data");
    test::RasterSpec nothing;
    nothing.nodata = 5;
    nothing.geo = {459'950, 1, 0, 101'080, 0, -1};
    refused(test::write_heights(folder.path() / "nothing.tif", nothing, level), "no heights");
    test::RasterSpec strip;
    strip.width = 10'000;
    strip.height = 1;
    strip.geo = {455'000, 1, 0, 101'080, 0, -1};
    refused(test::write_heights(folder.path() / "strip.tif", strip, level), "a strip");
    refused(folder.path() / "missing.tif", "missing.tif");
    world->editable_info().crs_wkt.clear();
    refused(folder.path() / "within.tif", "no place on Earth");
}

}  // namespace
