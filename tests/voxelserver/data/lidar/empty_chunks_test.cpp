// COPC files whose chunk table names chunks without points, as some writers leave them: valid, and
// read by PDAL, laspy and lasR. LASzip writes none, so they are kept: twice the same 30 points, in
// chunks of 0, 30, 0, 0, 30 and 0 points with 12 bytes in each empty one; and once these points
// with an empty chunk of no bytes behind them.
#include <cstring>

#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/data/lidar/las_bytes.hpp"
#include "voxelserver/data/lidar/chunk_table.hpp"
#include "voxelserver/data/lidar/spatial_index.hpp"
#include "voxelserver/tools/laz/point_stream.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

constexpr std::uint32_t kPoints = 30;
constexpr std::size_t kCountAt = 247;
const fs::path kFixtures = fs::path(TERRAVOX_SOURCE_DIR) / "tests/fixtures/lidar";

}  // namespace

TEST_CASE("chunks without points are passed over wherever LASzip can seek past them",
          "[voxelserver][lidar][copc]") {
    const TemporaryFolder folder;
    write_sample(folder.path() / "once.las", 6, kPoints);
    const auto once = all_points(folder.path() / "once.las");
    const fs::path file = kFixtures / "empty_chunks.copc.laz";
    const lidar::LasInfo info = lidar::read_las_info(file);
    CHECK(info.chunks->size() == 6);
    const auto points = all_points(file);
    REQUIRE(points.size() == 2 * kPoints);
    for (std::size_t i = 0; i < points.size(); ++i) {
        INFO("point " << i);
        CHECK(same_point(points[i], once[i % kPoints]));
    }
    // From the last to the first, so that nothing goes by what was read before.
    for (std::uint64_t i = points.size(); i-- > 0;)
        lidar::read_las_points(info, {i, i + 1}, [&](const pointcloud::Point& p) {
            CHECK(same_point(p, once[i % kPoints]));
        });
    for (const auto& range : lidar::split_by_chunk(info, 1))
        CHECK(range.end - range.begin == kPoints);
    const auto index = lidar::read_spatial_index(info);
    REQUIRE(index);
    std::uint64_t found = 0;
    for (const auto& range : index->ranges_over(info.min[0], info.min[1], info.max[0], info.max[1]))
        found += range.end - range.begin;
    CHECK(found == info.point_count);
    CHECK(lidar::sample_points(info, 10).size() >= 10);
    laz::PointStream stream(info);
    for (std::size_t i = 0; i < points.size(); ++i) {
        REQUIRE(stream.next());
        CHECK(stream.point().X * info.scale[0] + info.offset[0] == once[i % kPoints].x);
    }
    CHECK_FALSE(stream.next());
}

TEST_CASE("a chunk table whose chunks do not hold all points is refused",
          "[voxelserver][lidar][copc]") {
    struct Case {
        const char* file;
        std::uint64_t count;
        const char* said;
    };
    const auto c = GENERATE(values<Case>({
        {"empty_chunks.copc.laz", 61, "61 points; its chunks hold 60"},
        {"empty_chunks.copc.laz", 59, "chunk 4 of 30 points; allowed: 0 to 29"},
        {"chunk_of_no_bytes.copc.laz", kPoints, "chunk 1 of 0 bytes; allowed: 1 to"},
    }));
    const TemporaryFolder folder;
    std::string bytes = file_bytes(kFixtures / c.file);
    std::memcpy(bytes.data() + kCountAt, &c.count, sizeof c.count);
    write_bytes(folder.path() / c.file, bytes);
    CHECK_THROWS_WITH(lidar::read_las_info(folder.path() / c.file), contains(c.said));
}
