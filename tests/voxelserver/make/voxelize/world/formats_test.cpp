// The same survey in different formats makes the same boxes.
#include "tests/catch.hpp"
#include "tests/voxelserver/data/ply/ply_bytes.hpp"
#include "tests/voxelserver/make/voxelize/world/cloud.hpp"
#include "voxelserver/data/lidar/las_source.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

/// Hills with houses, trees, a lake and colours.
Cloud made_survey(unsigned seed) {
    std::mt19937 random(seed);
    Cloud out;
    for (int i = 0; i < 60'000; ++i) {
        const double east = static_cast<double>(random() % 150'000) / 1000;
        const double north = static_cast<double>(random() % 150'000) / 1000;
        const double ground = 150 + 4 * std::sin(east / 21) + 3 * std::cos(north / 17);
        const bool lake = std::hypot(east - 100, north - 40) < 15;
        const bool house = std::abs(east - 40) < 8 && std::abs(north - 90) < 6;
        const bool tree = !lake && !house && random() % 7 == 0;
        const int source_class = lake ? 9 : house ? 6 : tree ? 5 : 2;
        const double height = lake ? 146 : ground + (house ? 7 : tree ? 5 : 0);
        const auto grey = static_cast<std::uint16_t>(random());
        out.add(east, north, std::round(height * 1000) / 1000, source_class, {grey, grey, 300});
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
    write_file(ply, ply_bytes(list_points(las), kind, std::string("crs ") + kCrs));

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
