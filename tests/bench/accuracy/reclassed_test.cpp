// Surveys that do not distinguish bridges from the ground.
#include "tests/bench/accuracy/reclassed.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "voxelserver/lidar/las_file.hpp"
#include "voxelserver/lidar/las_writer.hpp"

using namespace terravox;

TEST_CASE("points of one class get another, and nothing else changes", "[bench][accuracy]") {
    const test::TemporaryFolder folder;
    const auto file = folder.path() / "a.laz";
    lidar::LasWriterOptions options;
    options.point_format = 7;
    lidar::LasWriter writer(file, options);
    for (int i = 0; i < 100; ++i) {
        lidar::LasWritePoint p;
        p.x = i * 0.37;
        p.y = 50 - i * 0.11;
        p.z = 400 + i * 0.01;
        p.classification = static_cast<std::uint8_t>(i % 20);
        p.rgb = {static_cast<std::uint16_t>(i * 256), 7, 9};
        writer.write(p);
    }
    writer.close();
    const auto copies = bench::reclass({file}, 17, 2, folder.path() / "copies");
    REQUIRE(copies == std::vector{folder.path() / "copies" / "a.laz"});
    const auto points_of = [](const std::filesystem::path& path) {
        const auto info = lidar::read_las_info(path);
        std::vector<pointcloud::Point> out;
        lidar::read_las_points(info, {0, info.point_count},
                               [&](const pointcloud::Point& p) { out.push_back(p); });
        return out;
    };
    const auto before = points_of(file);
    const auto after = points_of(copies.front());
    REQUIRE(after.size() == before.size());
    for (std::size_t i = 0; i < before.size(); ++i) {
        INFO("point " << i);
        CHECK((after[i].x == before[i].x && after[i].y == before[i].y &&
               after[i].z == before[i].z && after[i].rgb == before[i].rgb));
        CHECK(after[i].classification ==
              (before[i].classification == 17 ? 2 : before[i].classification));
    }
}
