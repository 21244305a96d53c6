// The same survey in different formats makes the same boxes.
// What points become in a whole world: every class seen, bridges that no class names.
#include <random>

#include "tests/catch.hpp"
#include "tests/voxelserver/data/ply/ply_bytes.hpp"
#include "tests/voxelserver/make/voxelize/world/cloud.hpp"
#include "voxelserver/data/lidar/las_source.hpp"
#include "voxelserver/make/voxelize/points/class_table.hpp"

using namespace terravox;
using namespace terravox::test;
using voxel::Material;
using voxelize::Role;

namespace {

/// Hills with a lake, houses and colours.
Cloud made_survey(unsigned seed) {
    std::mt19937 random(seed);
    Cloud out;
    for (int i = 0; i < 60'000; ++i) {
        const double east = static_cast<double>(random() % 150'000) / 1000;
        const double north = static_cast<double>(random() % 150'000) / 1000;
        const auto grey = static_cast<std::uint16_t>(random());
        const int source_class = std::hypot(east - 100, north - 40) < 15 ? 9 : random() % 7 ? 2 : 5;
        const double height =
            source_class == 9 ? 146 : 150 + static_cast<double>(random() % 5000) / 1000;
        out.add(east, north, height, source_class, {grey, grey, 300});
    }
    return out;
}

std::vector<pointcloud::Point> list_points(const std::filesystem::path& las) {
    const lidar::LasSource source(las);
    std::vector<pointcloud::Point> out;
    const pointcloud::PointRange all{0, source.info().point_count};
    source.read({&all, 1}, [&](std::span<const pointcloud::Point> batch) {
        out.insert(out.end(), batch.begin(), batch.end());
    });
    return out;
}

Checksums collect_boxes(const voxelize::LidarWorldOptions& options) {
    OpenWorld open(options);
    return checksums(open.world(), all_keys(open.info(), 0));
}

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

}  // namespace

TEST_CASE("the same points as LAZ and as PLY make the same boxes",
          "[voxelserver][voxelize][formats]") {
    const unsigned seed = GENERATE(range(1U, 4U));
    INFO("seed " << seed);
    const TemporaryFolder folder;
    const auto las = folder.path() / "a.laz";
    const auto ply = folder.path() / "a.ply";
    made_survey(seed).write(las, kCrs, 7);
    const auto kind = std::array{PlyKind::kText, PlyKind::kLittle, PlyKind::kBig}[seed - 1];
    write_content(ply, ply_bytes(list_points(las), kind, std::string("crs ") + kCrs));

    const Checksums wanted = collect_boxes(OpenWorld::with(las));
    REQUIRE(wanted.size() > 8);
    CHECK(collect_boxes(OpenWorld::with(ply)) == wanted);

    auto in_parts = OpenWorld::with(ply);
    in_parts.memory_bytes = std::size_t{1} << 20;  // the file does not fit: it is read in parts
    CHECK(collect_boxes(in_parts) == wanted);

    auto with_cache = OpenWorld::with(ply);
    with_cache.cache_dir = folder.path() / "cache";
    CHECK(collect_boxes(with_cache) == wanted);
    CHECK_FALSE(std::filesystem::is_empty(folder.path() / "cache" / "squares"));
    CHECK(collect_boxes(with_cache) == wanted);
}

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
