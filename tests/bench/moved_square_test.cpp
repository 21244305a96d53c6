#include "tests/bench/moved_square.hpp"

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/data/lidar/read_points.hpp"
#include "voxelserver/data/lidar/las_file.hpp"
#include "voxelserver/data/lidar/las_writer.hpp"

using namespace terravox;
using namespace terravox::bench;

TEST_CASE("a moved copy has other places and the same points", "[bench][moved]") {
    const test::TemporaryFolder folder;
    lidar::LasWriterOptions options;
    options.scale = {0.001, 0.001, 0.001};
    options.offset = {462000, 101000, 0};
    lidar::LasWriter writer(folder.path() / "points.laz", options);
    for (int i = 0; i < 100; ++i) {
        lidar::LasWritePoint p;
        p.x = 462000.25 + i;
        p.y = 101000.25 + i;
        p.z = 300;
        writer.write(p);
    }
    writer.close();
    copy_moved(folder.path() / "points.laz", folder.path() / "moved.laz", 3000, -1000);
    const auto from = lidar::read_las_info(folder.path() / "points.laz");
    const auto to = lidar::read_las_info(folder.path() / "moved.laz");
    CHECK(to.point_count == from.point_count);
    CHECK(to.min[0] == Approx(from.min[0] + 3000));
    CHECK(to.max[1] == Approx(from.max[1] - 1000));
    double east = 0;
    double north = 0;
    lidar::read_las_points(to, {0, 1}, [&](const pointcloud::Point& p) {
        east = p.x;
        north = p.y;
    });
    CHECK(east == Approx(465000.25));
    CHECK(north == Approx(100000.25));
    CHECK_THROWS_AS(copy_moved(folder.path() / "none.laz", folder.path() / "x.laz", 0, 0),
                    util::Error);
}
