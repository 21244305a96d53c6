// What points become: every class seen, walls to the local ground, open bridges, flat lakes, rivers
// without ridges.
#include <set>

#include "tests/catch.hpp"
#include "tests/voxelserver/voxelize/world/cloud.hpp"
#include "voxelserver/voxelize/points/class_table.hpp"

using namespace terravox;
using namespace terravox::test;
using voxel::Material;
using voxelize::Role;

namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

bool terrain(Material m) {
    return m == Material::kGround || m == Material::kGrass || m == Material::kSoil ||
           m == Material::kRock || m == Material::kRoad || m == Material::kSand;
}

}  // namespace

TEST_CASE("all 256 classes can be found in the voxels, but for those that are noise",
          "[voxelserver][voxelize]") {
    const std::string table_id = GENERATE("asprs", "si-clss", "fr-lidarhd", "nl-ahn", "de-by");
    INFO(table_id);
    const auto table = voxelize::load_class_table(table_id);
    // A block of 3 x 3 columns for each class, on a plain.
    Cloud cloud;
    constexpr double kGround = 100.5;
    constexpr double kPitch = 8;
    const auto code_at = [](double e, double n) {
        return static_cast<int>(n / kPitch) * 16 + static_cast<int>(e / kPitch);
    };
    const auto in_block = [](double e, double n) {
        return std::fmod(e, kPitch) >= 2 && std::fmod(e, kPitch) < 5 && std::fmod(n, kPitch) >= 2 &&
               std::fmod(n, kPitch) < 5;
    };
    cloud.cover(0, 0, 128, 128, 0.5, 2, [&](double e, double n) {
        const Role role = table.meaning[static_cast<std::size_t>(code_at(e, n))].role;
        return in_block(e, n) && (role == Role::kGround || role == Role::kWater) ? kNothing
                                                                                 : kGround;
    });
    for (int code = 0; code < 256; ++code) {
        const double e0 = code % 16 * kPitch + 2;
        const double n0 = code / 16 * kPitch + 2;
        const Role role = table.meaning[static_cast<std::size_t>(code)].role;
        const double height = role == Role::kGround || role == Role::kWater      ? kGround
                              : role == Role::kBuilding || role == Role::kBridge ? kGround + 5
                                                                                 : kGround + 2;
        cloud.cover(e0, n0, e0 + 3, n0 + 3, 0.5, code, [&](double, double) { return height; });
    }
    const TemporaryFolder folder;
    cloud.write(folder.path() / "all.las");
    OpenWorld world(folder.path() / "all.las", table_id);
    std::string missing;
    std::string shown;
    for (int code = 0; code < 256; ++code) {
        const std::int32_t x = voxel_x(code % 16 * kPitch + 3.5);
        const std::int32_t z = voxel_z(code / 16 * kPitch + 3.5);
        bool found = false;
        for (std::int32_t y = 90; y < 110; ++y)
            if (const auto v = world.at(x, y, z);
                v && v->source_class == code && v->material != Material::kRock)
                found = true;
        const bool dropped = table.meaning[static_cast<std::size_t>(code)].role == Role::kDrop;
        if (!dropped && !found)
            missing += " " + std::to_string(code);
        if (dropped && found)
            shown += " " + std::to_string(code);
    }
    CHECK(missing == "");
    CHECK(shown == "");
}

TEST_CASE("walls go down to the ground next to them, on a slope too", "[voxelserver][voxelize]") {
    const auto slope = [](double e, double) { return 100.5 + 0.25 * e; };
    Cloud cloud;
    cloud.cover(0, 0, 100, 60, 0.5, 2, [&](double e, double n) {
        return e >= 30 && e < 60 && n >= 20 && n < 40 ? kNothing : slope(e, n);
    });
    cloud.cover(30, 20, 60, 40, 0.5, 6, [](double, double) { return 130.5; });
    const TemporaryFolder folder;
    cloud.write(folder.path() / "house.laz");
    OpenWorld world(folder.path() / "house.laz");
    for (const double n : {20.5, 39.5})
        for (double e = 30.5; e < 60; ++e) {
            const std::int32_t x = voxel_x(e);
            const std::int32_t z = voxel_z(n);
            const std::int32_t local = static_cast<std::int32_t>(std::floor(slope(e, n)));
            INFO("east " << e << ", north " << n << ", local ground " << local);
            REQUIRE(world.top(x, z) == 130);
            CHECK(world.material(x, 130, z) == Material::kFlatRoof);
            std::int32_t y = 129;
            while (world.material(x, y, z) == Material::kWall)
                --y;
            CHECK(std::abs(y - local) <= 1);
            CHECK(terrain(world.material(x, y, z)));
        }
    // The ground next to the house is not lifted by it.
    for (double e = 2.5; e < 98; ++e)
        CHECK(world.top(voxel_x(e), voxel_z(10.5)) ==
              static_cast<std::int32_t>(std::floor(slope(e, 0))));
}

TEST_CASE("a bridge is open beneath", "[voxelserver][voxelize]") {
    Cloud cloud;
    const auto valley = [](double e, double) { return 100.5 + std::abs(e - 50) * 0.4; };
    cloud.cover(0, 0, 100, 40, 0.5, 2,
                [&](double e, double n) { return n >= 18 && n < 22 ? kNothing : valley(e, n); });
    cloud.cover(10, 18, 90, 22, 0.5, 17, [](double, double) { return 118.5; });
    const TemporaryFolder folder;
    cloud.write(folder.path() / "bridge.laz");
    OpenWorld world(folder.path() / "bridge.laz");
    for (double e = 25.5; e < 75; ++e) {
        const std::int32_t x = voxel_x(e);
        const std::int32_t z = voxel_z(20.5);
        INFO("east " << e);
        CHECK(world.material(x, 118, z) == Material::kBridge);
        for (std::int32_t y = static_cast<std::int32_t>(valley(e, 0)) + 2; y < 117; ++y)
            CHECK(world.material(x, y, z) == Material::kAir);
        const auto ground = world.highest(x, z, [](const auto& v) { return terrain(v.material); });
        REQUIRE(ground);
        CHECK(std::abs(*ground - static_cast<std::int32_t>(std::floor(valley(e, 0)))) <= 1);
    }
}

TEST_CASE("a bridge that no class names is open beneath", "[voxelserver][voxelize][bridges]") {
    struct Case {
        const char* name;
        int code;
        int below;
        Material lies;
    };
    const auto c = GENERATE(values<Case>({{"ground over water", 2, 9, Material::kWater},
                                          {"unclassified over water", 1, 9, Material::kWater},
                                          {"ground over a road", 2, 2, Material::kGround}}));
    DYNAMIC_SECTION(c.name) {
        // From west to east over what lies from south to north.
        const auto low = [](double e) { return e >= 50 && e < 74; };
        const auto deck = [](double n) { return n >= 40 && n < 47; };
        Cloud cloud;
        cloud.cover(0, 0, 128, 90, 0.5, 2,
                    [&](double e, double) { return low(e) ? kNothing : 110.5; });
        cloud.cover(50, 0, 74, 90, 0.5, c.below,
                    [&](double, double n) { return deck(n) ? kNothing : 104.5; });
        cloud.cover(50, 40, 74, 47, 0.5, c.code, [](double, double) { return 110.5; });
        const TemporaryFolder folder;
        cloud.write(folder.path() / "bridge.laz");
        OpenWorld world(folder.path() / "bridge.laz");
        for (double e = 53.5; e < 71; ++e)
            for (double n = 41.5; n < 46; ++n) {
                const std::int32_t x = voxel_x(e);
                const std::int32_t z = voxel_z(n);
                INFO("east " << e << ", north " << n);
                REQUIRE(world.material(x, 110, z) == Material::kBridge);
                for (std::int32_t y = 105; y < 110; ++y)
                    REQUIRE(world.material(x, y, z) == Material::kAir);
                REQUIRE(world.material(x, 104, z) == c.lies);
            }
        for (const double e : {40.5, 85.5})
            CHECK(world.material(voxel_x(e), 110, voxel_z(43.5)) != Material::kBridge);
        CHECK(world.material(voxel_x(60.5), 110, voxel_z(30.5)) == Material::kAir);
    }
}

TEST_CASE(
    "a lake is flat, though its level lies at a voxel's border and most pulses are lost in it",
    "[voxelserver][voxelize]") {
    Cloud cloud;
    std::mt19937 random(12);
    const auto lake = [](double e, double n) { return std::hypot(e - 150, n - 100) < 70; };
    cloud.cover(0, 0, 300, 200, 0.7, 2, [&](double e, double n) {
        return lake(e, n) ? kNothing
                          : 200.3 + std::max(0.0, std::hypot(e - 150, n - 100) - 70) * 0.1;
    });
    int returns = 0;
    for (int i = 0; i < 2500; ++i) {
        const double e = 80 + static_cast<double>(random() % 14'000) / 100;
        const double n = 30 + static_cast<double>(random() % 14'000) / 100;
        const double noise = (static_cast<double>(random() % 1001) - 500) / 500 * 0.12;
        if (lake(e, n)) {
            cloud.add(e, n, 200.0 + noise, 9);
            ++returns;
        }
    }
    REQUIRE(returns > 1000);
    const TemporaryFolder folder;
    cloud.write(folder.path() / "lake.laz");
    OpenWorld world(folder.path() / "lake.laz");
    std::set<std::int32_t> levels;
    int water = 0;
    int all = 0;
    for (double n = 32.5; n < 170; ++n)
        for (double e = 82.5; e < 220; ++e) {
            if (std::hypot(e - 150, n - 100) > 63)
                continue;  // nearer to the shore a cell of the terrain grid holds dry ground too
            ++all;
            const auto y = world.top(voxel_x(e), voxel_z(n));
            REQUIRE(y);
            if (world.material(voxel_x(e), *y, voxel_z(n)) != Material::kWater)
                continue;
            ++water;
            levels.insert(*y);
        }
    INFO(water << " of " << all << " columns are water");
    CHECK(water == all);
    CHECK(levels.size() == 1);
    CHECK((*levels.begin() == 199 || *levels.begin() == 200));
}

TEST_CASE("a river slopes without ridges or steps upstream", "[voxelserver][voxelize]") {
    Cloud cloud;
    std::mt19937 random(13);
    const auto level = [](double e) {
        return 150.2 + (400 - e) * 0.02;
    };  // flows east: 8 m in 400 m
    cloud.cover(0, 0, 400, 60, 0.7, 2,
                [&](double e, double n) { return n > 20 && n < 40 ? kNothing : level(e) + 1.5; });
    for (int i = 0; i < 3000; ++i) {
        const double e = static_cast<double>(random() % 40'000) / 100;
        const double n = 20.2 + static_cast<double>(random() % 1960) / 100;
        cloud.add(e, n, level(e) + (static_cast<double>(random() % 1001) - 500) / 500 * 0.1, 9);
    }
    const TemporaryFolder folder;
    cloud.write(folder.path() / "river.laz");
    OpenWorld world(folder.path() / "river.laz");
    int climbs = 0;
    int far = 0;
    int dry = 0;
    for (double n = 22.5; n < 38; ++n) {
        std::optional<std::int32_t> last;
        for (double e = 5.5; e < 395; ++e) {
            const auto y = world.top(voxel_x(e), voxel_z(n));
            REQUIRE(y);
            if (world.material(voxel_x(e), *y, voxel_z(n)) != Material::kWater)
                ++dry;
            far += std::abs(*y - level(e)) > 1.5 ? 1 : 0;
            if (last && *y > *last)
                ++climbs;
            last = y;
        }
    }
    CHECK(dry == 0);
    CHECK(far == 0);
    CHECK(climbs == 0);
}

TEST_CASE("trees stand on the ground and keep their class", "[voxelserver][voxelize]") {
    Cloud cloud;
    cloud.cover(0, 0, 64, 64, 0.5, 2, [](double, double) { return 10.5; });
    cloud.cover(30, 30, 34, 34, 0.5, 5,
                [](double e, double n) { return 20.5 - std::hypot(e - 32, n - 32); });
    const TemporaryFolder folder;
    cloud.write(folder.path() / "tree.laz");
    OpenWorld world(folder.path() / "tree.laz");
    const auto top = world.top_voxel(voxel_x(32.2), voxel_z(32.2));
    REQUIRE(top);
    CHECK(top->material == Material::kHighVegetation);
    CHECK(top->source_class == 5);
    CHECK(world.top(voxel_x(10.5), voxel_z(10.5)) == 10);
}

TEST_CASE("heights are never squeezed: a mountain of 2864 m and a mine below the sea",
          "[voxelserver][voxelize]") {
    const double height = GENERATE(2863.5, -387.5, 0.5, -0.5, 8848.5);
    Cloud cloud;
    cloud.cover(0, 0, 40, 40, 0.5, 2, [&](double, double) { return height; });
    const TemporaryFolder folder;
    cloud.write(folder.path() / "high.laz");
    OpenWorld world(folder.path() / "high.laz");
    CHECK(world.top(voxel_x(20.5), voxel_z(20.5)) == static_cast<std::int32_t>(std::floor(height)));
    CHECK(world.info().bounds.max[1] == static_cast<std::int32_t>(std::floor(height)) + 1);
}

TEST_CASE("voxels of any size cover the same ground", "[voxelserver][voxelize]") {
    Cloud cloud;
    cloud.cover(0, 0, 60, 60, 0.2, 2, [](double e, double) { return 50.1 + e / 10; });
    const TemporaryFolder folder;
    cloud.write(folder.path() / "ramp.laz");
    const double voxel_m = GENERATE(0.25, 0.5, 1.0, 2.0);
    INFO(voxel_m << " m");
    auto options = OpenWorld::with(folder.path() / "ramp.laz");
    options.voxel_m = voxel_m;
    OpenWorld world(options);
    CHECK(world.info().voxel_m == voxel_m);
    for (double e = 4.1; e < 58; e += 3.7) {
        const auto x = static_cast<std::int32_t>(std::floor((kEast0 + e) / voxel_m));
        const auto z = static_cast<std::int32_t>(std::floor(-(kNorth0 + 30.1) / voxel_m));
        const auto y = world.top(x, z);
        REQUIRE(y);
        CHECK(std::abs(*y - std::floor((50.1 + e / 10) / voxel_m)) <= 1);
    }
}
