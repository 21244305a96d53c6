#include <algorithm>
#include <cmath>

#include "tests/catch.hpp"
#include "tests/raytracer/analyse/evaluators/measured.hpp"

namespace {

using namespace terravox;
using test::ArrayWorld;
using test::Measured;
using voxel::Material;

using WorldPtr = std::unique_ptr<ArrayWorld>;

scene::Scene sky_scene(int directions = 256) {
    scene::Scene scene = test::analysis_scene(core::AnalysisKind::kSky);
    scene.analysis.directions = directions;
    return scene;
}

Measured measure_sky(voxel::World& world, const scene::Scene& scene = sky_scene(),
                     const Measured::Options& options = {}) {
    return {world, scene, options};
}

Measured::Options within(const ArrayWorld::Coord& min, const ArrayWorld::Coord& max) {
    Measured::Options out;
    out.area = voxel::VoxelBounds{min, max};
    return out;
}

/// A street from north to south between two blocks that are as long as the world.
/// @param width of the street, odd: the middle of a cell is the middle of the street
/// @param height of the blocks
WorldPtr street(int width, int height) {
    const int half = width / 2;
    const int length = 12 * std::max(width, height);
    auto world = std::make_unique<ArrayWorld>(ArrayWorld::Coord{-half - 3, -1, -length},
                                              ArrayWorld::Coord{half + 4, height, length});
    world->fill({-half - 3, -1, -length}, {half + 4, 0, length}, Material::kRoad);
    world->fill({-half - 3, 0, -length}, {-half, height, length}, Material::kWall);
    world->fill({half + 1, 0, -length}, {half + 4, height, length}, Material::kWall);
    return world;
}

/// A round pit; its rim is as high everywhere.
WorldPtr basin(int radius, int depth) {
    const int edge = radius + 4;
    auto world = std::make_unique<ArrayWorld>(ArrayWorld::Coord{-edge, -1, -edge},
                                              ArrayWorld::Coord{edge + 1, depth, edge + 1});
    world->fill_with([&](int x, int y, int z) {
        if (y < 0)
            return Material::kGround;
        return x * x + z * z > radius * radius ? Material::kRock : Material::kAir;
    });
    return world;
}

/// Mean of a band along the middle of a street.
double mean_along(const Measured& raster, int from, int to, std::string_view band) {
    double sum = 0;
    for (int z = from; z < to; ++z)
        sum += static_cast<double>(raster.at(0, z, band));
    return sum / (to - from);
}

/// Blocks and a bridge at random places, the same for a seed.
WorldPtr blocks_at_random(std::uint64_t seed, int count) {
    auto world = std::make_unique<ArrayWorld>(ArrayWorld::Coord{-20, -2, -20},
                                              ArrayWorld::Coord{20, 30, 20});
    world->fill({-20, -2, -20}, {20, 0, 20}, Material::kGrass);
    for (int i = 0; i < count; ++i) {
        const std::uint64_t h = core::hash64(seed, static_cast<std::uint64_t>(i));
        const int x = static_cast<int>(h % 36) - 20;
        const int z = static_cast<int>(h >> 8 & 31) - 18;
        const int low = (h >> 16 & 1) != 0 ? 0 : 6;
        const int high = low + 1 + static_cast<int>(h >> 20 & 15);
        world->fill({x, low, z}, {x + 4, high, z + 4}, Material::kWall);
    }
    return world;
}

}  // namespace

TEST_CASE("an open plane sees all of the sky", "[raytracer][analyse]") {
    ArrayWorld world({-20, -2, -20}, {20, 0, 20});
    world.fill({-20, -2, -20}, {20, 0, 20}, Material::kGrass);
    const Measured raster = measure_sky(world);
    for (int z = -20; z < 20; ++z)
        for (int x = -20; x < 20; ++x) {
            REQUIRE(std::abs(raster.at(x, z, "svf") - 1) < 1e-5F);
            REQUIRE(std::abs(raster.at(x, z, "sky_view_solid") - 1) < 1e-5F);
            REQUIRE(std::abs(raster.at(x, z, "openness") - 90) < 1e-3F);
            REQUIRE(raster.at(x, z, "hole") == 0);
        }
}

TEST_CASE("the ground inside of a closed hall sees no sky, and its roof all",
          "[raytracer][analyse]") {
    ArrayWorld world({-9, -2, -9}, {9, 10, 9});
    world.fill({-9, -2, -9}, {9, 0, 9}, Material::kGround);
    world.fill({-9, 0, -9}, {9, 9, 9}, Material::kBridge);
    world.fill({-8, 0, -8}, {8, 8, 8}, Material::kAir);
    scene::Scene scene = sky_scene();
    scene.analysis.surface = core::AnalysisSurface::kGround;
    const Measured inside = measure_sky(world, scene);
    CHECK(inside.at(0, 0, "svf") == 0);
    CHECK(inside.at(7, -8, "sky_view_solid") == 0);
    CHECK(inside.at(-8, 3, "openness") == 0);
    CHECK(measure_sky(world).at(0, 0, "svf") > 0.9999F);
}

TEST_CASE("people stand in low vegetation, and below crowns", "[raytracer][analyse]") {
    ArrayWorld world({-20, -2, -20}, {20, 30, 20});
    world.fill({-20, -2, -20}, {20, 0, 20}, Material::kGround);
    world.fill({-20, 0, -20}, {0, 2, 20}, Material::kLowVegetation);
    world.fill({5, 6, -20}, {20, 10, 20}, Material::kHighVegetation);
    scene::Scene scene = sky_scene();
    scene.analysis.surface = core::AnalysisSurface::kGround;
    const Measured raster = measure_sky(world, scene);
    // Between stalks there is none; below the crown there is some from the side.
    CHECK(raster.at(-10, 0, "svf") > 0.8F);
    CHECK(raster.at(12, 0, "svf") < 0.3F);
    CHECK(raster.at(6, 0, "svf") > 0);
}

TEST_CASE("grass, trunks and wires hide no sky from the ground, unless they are to block",
          "[raytracer][analyse]") {
    const auto bare = blocks_at_random(5, 12);
    const auto grown = blocks_at_random(5, 12);
    grown->fill_with([&](int x, int y, int z) {
        const Material there = bare->at(x, y, z);
        if (there != Material::kAir || y < 0 || (x + z) % 3 == 0)
            return there;
        if (y < 2)
            return Material::kLowVegetation;
        if (y < 12 && x % 7 == 0 && z % 7 == 0)
            return Material::kTrunk;
        return y == 24 && z % 5 == 0 ? Material::kWire : Material::kAir;
    });
    scene::Scene scene = sky_scene();
    scene.analysis.surface = core::AnalysisSurface::kGround;
    const Measured wanted = measure_sky(*bare, scene);
    const Measured passed = measure_sky(*grown, scene);
    scene.analysis.thin_blocks = true;
    const Measured blocked = measure_sky(*grown, scene);
    int cells = 0;
    for (int z = -20; z < 20; ++z)
        for (int x = -20; x < 20; ++x) {
            // Where nothing grows, the point of measurement is that of the bare world.
            if ((x + z) % 3 != 0)
                continue;
            ++cells;
            REQUIRE(passed.at(x, z, "svf") == wanted.at(x, z, "svf"));
            REQUIRE(blocked.at(x, z, "svf") <= passed.at(x, z, "svf"));
        }
    CHECK(cells > 500);
    CHECK(blocked.at(0, 0, "svf") < passed.at(0, 0, "svf"));
    CHECK(measure_sky(*grown, scene, {3, 7}).values() == blocked.values());
    scene.analysis.thin_blocks = false;
    CHECK(measure_sky(*grown, scene, {3, 7}).values() == passed.values());
    // Seen from above, what is highest blocks, as for tools that know heights only.
    scene.analysis.surface = core::AnalysisSurface::kTop;
    const Measured top = measure_sky(*grown, scene);
    scene.analysis.thin_blocks = true;
    CHECK(measure_sky(*grown, scene).values() == top.values());
}

TEST_CASE("street canyons have the sky-view factor of the closed form", "[raytracer][analyse]") {
    struct Canyon {
        const char* name;
        int width;
        int height;
    };
    const Canyon canyons[] = {{"H/W 0.5", 41, 20}, {"H/W 1", 41, 41}, {"H/W 2", 21, 42}};
    for (const Canyon& c : canyons) {
        INFO(c.name);
        const WorldPtr world = street(c.width, c.height);
        const Measured raster = measure_sky(*world, sky_scene(), within({0, -1, -32}, {1, 0, 32}));
        // The sine of the angle between the wall's top and the zenith.
        const double expected = c.width / 2.0 / std::hypot(c.width / 2.0, c.height);
        const double svf = mean_along(raster, -32, 32, "svf");
        CHECK(std::abs(svf - expected) < 0.005);
        double square = 0;
        for (int z = -32; z < 32; ++z) {
            const double error = static_cast<double>(raster.at(0, z, "svf")) - expected;
            square += error * error / 64;
        }
        CHECK(std::sqrt(square) < 0.013);
    }
}

TEST_CASE("round basins have the sky-view factors of the closed forms", "[raytracer][analyse]") {
    struct Basin {
        const char* name;
        int radius;
        int depth;
    };
    // Depth to radius 0.5, 1 and 2: 0.8, 0.5 and 0.2, in voxels so fine that their steps matter
    // little.
    const Basin basins[] = {{"0.8", 160, 80}, {"0.5", 120, 120}, {"0.2", 70, 140}};
    for (const Basin& b : basins) {
        INFO(b.name);
        const WorldPtr world = basin(b.radius, b.depth);
        const Measured raster = measure_sky(*world, sky_scene(), within({0, -1, 0}, {1, 0, 1}));
        const double horizon = std::atan2(b.depth, b.radius);
        const double cosine = std::cos(horizon);
        CHECK(std::abs(static_cast<double>(raster.at(0, 0, "svf")) - cosine * cosine) < 0.01);
        CHECK(std::abs(static_cast<double>(raster.at(0, 0, "sky_view_solid")) -
                       (1 - std::sin(horizon))) < 0.01);
        CHECK(std::abs(static_cast<double>(raster.at(0, 0, "openness")) -
                       (90 - horizon * 180 / det::kPi)) < 0.9);
    }
}

TEST_CASE("nothing that is added shows more sky", "[raytracer][analyse]") {
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
        INFO("seed " << seed);
        const WorldPtr few = blocks_at_random(seed, 6);
        const WorldPtr many = blocks_at_random(seed, 12);
        scene::Scene scene = sky_scene(64);
        scene.analysis.surface = core::AnalysisSurface::kGround;
        const Measured before = measure_sky(*few, scene);
        const Measured after = measure_sky(*many, scene);
        int less = 0;
        for (int z = -20; z < 20; ++z)
            for (int x = -20; x < 20; ++x)
                for (const std::string_view band : {"svf", "sky_view_solid", "openness"}) {
                    const float then = before.at(x, z, band);
                    const float now = after.at(x, z, band);
                    if (then == core::kNoData || now == core::kNoData)
                        continue;
                    REQUIRE(now <= then);
                    less += now < then ? 1 : 0;
                }
        CHECK(less > 500);
    }
}

TEST_CASE("rays of a limited range see no farther", "[raytracer][analyse]") {
    const WorldPtr world = street(41, 41);
    scene::Scene scene = sky_scene();
    scene.analysis.range_m = 20;
    const Measured::Options middle = within({0, -1, 0}, {1, 0, 1});
    CHECK(measure_sky(*world, scene, middle).at(0, 0, "svf") > 0.9999F);
    scene.analysis.range_m = 30;
    CHECK(measure_sky(*world, scene, middle).at(0, 0, "svf") < 0.99F);
}

TEST_CASE("a cell whose rays meet a hole has no value, and is counted", "[raytracer][analyse]") {
    ArrayWorld world({-40, -2, -20}, {100, 30, 20});
    world.fill({-40, -2, -20}, {100, 0, 20}, Material::kGrass);
    world.fill({70, 0, -20}, {74, 30, 20}, Material::kWall);
    world.make_hole({0, 1, 0, 0});
    const Measured raster = measure_sky(world);
    CHECK(raster.at(90, 10, "svf") == core::kNoData);
    CHECK(raster.at(90, 10, "hole") == 1);
    // Its horizon has the hole in it.
    CHECK(raster.at(50, 10, "svf") == core::kNoData);
    CHECK(raster.at(50, 10, "hole") == 1);
    CHECK(raster.counts().holes.size() == 1);
}
