// What points become in a whole world: every class seen, bridges that no class names.
#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/world/cloud.hpp"
#include "voxelserver/make/voxelize/points/class_table.hpp"

using namespace terravox;
using namespace terravox::test;
using voxel::Material;
using voxelize::Role;

namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

}  // namespace

TEST_CASE("all 256 classes can be found in the voxels, but for those that are noise",
          "[voxelserver][voxelize]") {
    const std::string table_id = GENERATE("asprs", "fr-lidarhd");
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

TEST_CASE("a bridge that no class names is open beneath", "[voxelserver][voxelize][bridges]") {
    // From west to east over water that flows from south to north.
    const int code = GENERATE(1, 2);
    const auto low = [](double e) { return e >= 50 && e < 74; };
    const auto deck = [](double n) { return n >= 40 && n < 47; };
    Cloud cloud;
    cloud.cover(0, 0, 128, 90, 0.5, 2, [&](double e, double) { return low(e) ? kNothing : 110.5; });
    cloud.cover(50, 0, 74, 90, 0.5, 9,
                [&](double, double n) { return deck(n) ? kNothing : 104.5; });
    cloud.cover(50, 40, 74, 47, 0.5, code, [](double, double) { return 110.5; });
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
            REQUIRE(world.material(x, 104, z) == Material::kWater);
        }
    for (const double e : {40.5, 85.5})
        CHECK(world.material(voxel_x(e), 110, voxel_z(43.5)) != Material::kBridge);
    CHECK(world.material(voxel_x(60.5), 110, voxel_z(30.5)) == Material::kAir);
}
