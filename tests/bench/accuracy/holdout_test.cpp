#include "tests/bench/accuracy/holdout.hpp"

#include <cmath>

#include "common/util/error.hpp"
#include "tests/bench/moved_square.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "voxelserver/lidar/las_file.hpp"
#include "voxelserver/lidar/las_writer.hpp"

using namespace terravox;
using namespace terravox::bench;

namespace {

double plane_m(double x, double y) {
    return 300 + 0.2 * (x - 462000) - 0.1 * (y - 101000);
}

/// Ground on a tilted plane, two points a metre, and a bush of class 3 over every tenth.
void write_plane(const std::filesystem::path& path) {
    lidar::LasWriterOptions options;
    options.scale = {0.001, 0.001, 0.001};
    options.offset = {462000, 101000, 0};
    lidar::LasWriter writer(path, options);
    int i = 0;
    for (double y = 101000.25; y < 101128; y += 0.5)
        for (double x = 462000.25; x < 462128; x += 0.5) {
            lidar::LasWritePoint p;
            p.x = x;
            p.y = y;
            p.z = plane_m(x, y);
            p.classification = 2;
            writer.write(p);
            if (++i % 10 == 0) {
                p.z += 1.5;
                p.classification = 3;
                writer.write(p);
            }
        }
    writer.close();
}

}  // namespace

TEST_CASE("every tenth ground point is left out, and nothing else", "[bench][accuracy][holdout]") {
    const test::TemporaryFolder folder;
    write_plane(folder.path() / "plane.laz");
    std::filesystem::create_directories(folder.path() / "rest");
    const auto held = hold_out_ground({folder.path() / "plane.laz"}, folder.path() / "rest", 10);
    const auto before = lidar::read_las_info(folder.path() / "plane.laz");
    const auto after = lidar::read_las_info(folder.path() / "rest" / "plane.laz");
    CHECK(held.size() == 6553);
    CHECK(before.point_count - after.point_count == held.size());
    std::size_t plants = 0;
    lidar::read_las_points(after, {0, after.point_count},
                           [&](const pointcloud::Point& p) { plants += p.classification == 3; });
    CHECK(plants == 6553);
    for (const HeldOut& p : held)
        CHECK(p.height_m == Approx(plane_m(p.x, p.y)).margin(0.002));
}

TEST_CASE("a plane is predicted where it was not seen", "[bench][accuracy][holdout]") {
    const test::TemporaryFolder folder;
    write_plane(folder.path() / "plane.laz");
    std::filesystem::create_directories(folder.path() / "rest");
    const auto held = hold_out_ground({folder.path() / "plane.laz"}, folder.path() / "rest", 10);
    voxelize::LidarWorldOptions options;
    options.files = {folder.path() / "rest"};
    options.crs = "EPSG:3794";
    util::StageTimes times;
    const auto world = voxelize::open_lidar_world(options, times);
    std::size_t without = 0;
    const Errors errors = predict_held_out(*world, held, without);
    CHECK(errors.count() + without == held.size());
    CHECK(errors.count() > held.size() * 9 / 10);
    CHECK(errors.rmse() < 0.06);
    CHECK(std::abs(errors.bias()) < 0.03);
}

TEST_CASE("a moved copy has other places and the same points", "[bench][moved]") {
    const test::TemporaryFolder folder;
    write_plane(folder.path() / "plane.laz");
    copy_moved(folder.path() / "plane.laz", folder.path() / "moved.laz", 3000, -1000);
    const auto from = lidar::read_las_info(folder.path() / "plane.laz");
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
