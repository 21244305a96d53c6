#include <cmath>
#include <functional>

#include "common/util/det_math.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/analyse/evaluators/period_light.hpp"

namespace {

using namespace terravox;
using core::WallSide;
using test::ArrayWorld;
using test::energy_scene;
using test::in_the_open;
using test::Light;
using test::Measured;
using voxel::Material;

constexpr double kRad = det::kPi / 180;
constexpr WallSide kSides[] = {WallSide::kNorth, WallSide::kEast, WallSide::kSouth,
                               WallSide::kWest};

/// A meadow of 80 x 80 m at height 0 with what stands on it.
std::unique_ptr<ArrayWorld> meadow_with(const std::function<Material(int, int, int)>& material_at) {
    constexpr int kHalf = 40;
    auto world = std::make_unique<ArrayWorld>(ArrayWorld::Coord{-kHalf, -2, -kHalf},
                                              ArrayWorld::Coord{kHalf, 24, kHalf});
    world->fill_with(
        [&](int x, int y, int z) { return y < 0 ? Material::kGrass : material_at(x, y, z); });
    world->editable_info().centre = test::kTown;
    return world;
}

/// A house with a flat roof, 12 m high: [-5, 5) x [-4, 4).
std::unique_ptr<ArrayWorld> house() {
    return meadow_with([](int x, int y, int z) {
        if (x < -5 || x >= 5 || z < -4 || z >= 4 || y >= 12)
            return Material::kAir;
        return y == 11 ? Material::kFlatRoof : Material::kWall;
    });
}

scene::Scene facade_scene(WallSide side, int storey) {
    scene::Scene scene = energy_scene(core::AnalysisKind::kFacade, "2026-06-01", "2026-06-30");
    scene.analysis.side = side;
    scene.analysis.storey = storey;
    return scene;
}

/// Sums over the walls of a raster.
struct Walls {
    int count = 0;
    double area_m2 = 0;
    double beam = 0;     ///< kWh
    double diffuse = 0;  ///< kWh
    double east = 0, north = 0;
    double farthest_deg = 0;  ///< of a wall's azimuth from `azimuth_deg`
};
Walls find_walls(const Measured& raster, double azimuth_deg = 0) {
    Walls out;
    for (int z = -40; z < 40; ++z)
        for (int x = -40; x < 40; ++x) {
            const double area = value(raster, x, z, "area");
            if (area <= 0)
                continue;
            const double azimuth = value(raster, x, z, "azimuth");
            ++out.count;
            out.area_m2 += area;
            out.beam += value(raster, x, z, "beam") * area;
            out.diffuse += value(raster, x, z, "diffuse") * area;
            out.east += std::sin(azimuth * kRad) * area;
            out.north += std::cos(azimuth * kRad) * area;
            out.farthest_deg =
                std::max(out.farthest_deg, std::abs(std::remainder(azimuth - azimuth_deg, 360.0)));
        }
    return out;
}

}  // namespace

TEST_CASE("an open wall gets the energy of the closed form, storey by storey",
          "[raytracer][analyse]") {
    const auto world = house();
    for (const WallSide side : kSides)
        for (const int storey : {0, 3}) {
            const scene::Scene scene = facade_scene(side, storey);
            INFO("side " << static_cast<int>(side) << ", storey " << storey);
            const core::Vec3 normal{
                static_cast<double>((side == WallSide::kEast) - (side == WallSide::kWest)), 0,
                static_cast<double>((side == WallSide::kSouth) - (side == WallSide::kNorth))};
            const Light expected = in_the_open(scene, normal, 11);
            const Measured raster(*world, scene, {});
            const bool is_long = side == WallSide::kNorth || side == WallSide::kSouth;
            const double azimuth = std::atan2(normal.x, -normal.z) / kRad;
            const Walls walls = find_walls(raster, azimuth);
            CHECK(walls.count == (is_long ? 10 : 8));
            CHECK(walls.area_m2 == Approx(walls.count * 3).epsilon(0.02));
            CHECK(walls.beam / walls.area_m2 == Approx(expected.beam).epsilon(0.01));
            CHECK(walls.diffuse / walls.area_m2 == Approx(expected.diffuse).epsilon(0.005));
            // In the middle of the wall, away from corners, which look round.
            const int x = is_long ? 0 : (side == WallSide::kEast ? 4 : -5);
            const int z = is_long ? (side == WallSide::kSouth ? 3 : -4) : 0;
            CHECK(value(raster, x, z, "bottom") == Approx(storey * 3));
            CHECK(value(raster, x, z, "height") == 3);
            CHECK(value(raster, x, z, "area") == Approx(3));
            CHECK(value(raster, x, z, "sky_view") == Approx(0.5));
            CHECK(value(raster, x, z, "reflected") == Approx(expected.reflected).epsilon(0.005));
            CHECK(std::abs(std::remainder(value(raster, x, z, "azimuth") - azimuth, 360.0)) < 1e-3);
            CHECK(value(raster, x, z, "kwh_m2") ==
                  Approx(value(raster, x, z, "beam") + value(raster, x, z, "diffuse") +
                         value(raster, x, z, "reflected")));
            CHECK(value(raster, 20, 20, "kwh_m2") == static_cast<double>(core::kNoData));
        }
    CHECK(find_walls(Measured(*world, facade_scene(WallSide::kSouth, 4), {})).count == 0);
}

TEST_CASE("an oblique wall has its own area and light, though its voxels are stairs",
          "[raytracer][analyse]") {
    const double degrees = GENERATE(20.0, 45.0, 63.0);
    INFO("turned by " << degrees);
    const double east = std::sin(degrees * kRad);
    const double south = std::cos(degrees * kRad);
    // 40 m x 20 m; one long wall looks to (east, south).
    const auto world = meadow_with([&](int x, int y, int z) {
        const double across = (x + 0.5) * east + (z + 0.5) * south;
        const double along = (x + 0.5) * south - (z + 0.5) * east;
        if (std::abs(across) >= 10 || std::abs(along) >= 20 || y >= 9)
            return Material::kAir;
        return y == 8 ? Material::kRoof : Material::kWall;
    });
    const Light expected = in_the_open(facade_scene(WallSide::kSouth, 1), {east, 0, south}, 11);
    const double azimuth_deg = 180 - degrees;
    double area_m2 = 0;
    double beam = 0;
    double diffuse = 0;
    double all_m2 = 0;
    for (const WallSide side : kSides) {
        const Measured raster(*world, facade_scene(side, 1), {});
        for (int z = -40; z < 40; ++z)
            for (int x = -40; x < 40; ++x) {
                const double area = value(raster, x, z, "area");
                if (area <= 0)
                    continue;
                all_m2 += area;
                const double off = value(raster, x, z, "azimuth") - azimuth_deg;
                if (std::abs(std::remainder(off, 360.0)) > 30)
                    continue;
                area_m2 += area;
                beam += value(raster, x, z, "beam") * area;
                diffuse += value(raster, x, z, "diffuse") * area;
            }
    }
    CHECK(all_m2 == Approx(3 * 120).epsilon(0.05));
    CHECK(area_m2 == Approx(3 * 40).epsilon(0.08));
    CHECK(beam / area_m2 == Approx(expected.beam).epsilon(0.03));
    CHECK(diffuse / area_m2 == Approx(expected.diffuse).epsilon(0.03));
}

TEST_CASE("where a building is open below its roof there is no wall", "[raytracer][analyse]") {
    // An arcade of 6 m, two bays deep, in the south of a house of 12 m.
    const auto world = meadow_with([](int x, int y, int z) {
        if (x < -10 || x >= 10 || z < -8 || z >= 8 || y >= 12 || (z >= 2 && y < 6))
            return Material::kAir;
        return y == 11 ? Material::kRoof : Material::kWall;
    });
    CHECK(find_walls(Measured(*world, facade_scene(WallSide::kSouth, 0), {})).count == 0);
    CHECK(find_walls(Measured(*world, facade_scene(WallSide::kSouth, 2), {})).count == 20);
    // The other walls reach the ground, but for the arcade's ends.
    CHECK(find_walls(Measured(*world, facade_scene(WallSide::kNorth, 0), {})).count == 20);
    CHECK(find_walls(Measured(*world, facade_scene(WallSide::kEast, 0), {})).count == 10);
}

TEST_CASE("crowns before and above a house hide no wall, and shade it", "[raytracer][analyse]") {
    const auto world = meadow_with([](int x, int y, int z) {
        const bool is_house = x >= -5 && x < 5 && z >= -4 && z < 4 && y < 12;
        if (is_house)
            return y == 11 ? Material::kRoof : Material::kWall;
        const bool is_crown = x >= -8 && x < 8 && z >= 2 && z < 10 && y >= 5 && y < 20;
        return is_crown ? Material::kHighVegetation : Material::kAir;
    });
    const scene::Scene scene = facade_scene(WallSide::kSouth, 0);
    const Walls shaded = find_walls(Measured(*world, scene, {}), 180);
    const Walls open = find_walls(Measured(*house(), scene, {}), 180);
    CHECK(shaded.count == open.count);
    CHECK(shaded.area_m2 == Approx(open.area_m2));
    CHECK(shaded.beam < open.beam * 0.5);
}

TEST_CASE("roofs that slope have no facades", "[raytracer][analyse]") {
    // A gable of 45 degrees over walls of 2 m to the eaves, which are too low to be told from steep
    // roofs.
    const auto world = meadow_with([](int x, int y, int z) {
        const int top = 1 + 8 - std::abs(2 * z + 1) / 2;
        const bool is_house = x >= -10 && x < 10 && z >= -8 && z < 8;
        if (!is_house || y >= top)
            return Material::kAir;
        return y == top - 1 ? Material::kRoof : Material::kWall;
    });
    CHECK(find_walls(Measured(*world, facade_scene(WallSide::kSouth, 0), {})).count == 0);
    // Its gable ends are walls, as high as the roof is there.
    const Measured east(*world, facade_scene(WallSide::kEast, 0), {});
    CHECK(value(east, 9, 0, "height") == 3);
    CHECK(find_walls(Measured(*world, facade_scene(WallSide::kEast, 2), {})).count > 2);
}

TEST_CASE("walls behind a hole are counted, never dark", "[raytracer][analyse]") {
    const auto world = house();
    world->make_hole({0, 0, 0, 0});
    const Measured raster(*world, facade_scene(WallSide::kSouth, 0), {});
    double holes = 0;
    for (int z = -40; z < 40; ++z)
        for (int x = -40; x < 40; ++x) {
            const double hole = value(raster, x, z, "hole");
            holes += hole;
            if (hole > 0)
                REQUIRE(value(raster, x, z, "kwh_m2") == static_cast<double>(core::kNoData));
        }
    CHECK(holes > 0);
}
