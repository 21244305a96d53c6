// Heights above different datums in one world.
#include "voxelserver/make/voxelize/points/file_crs.hpp"

#include <algorithm>

#include "tests/catch.hpp"
#include "tests/voxelserver/data/store/warnings.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

/// What is said of files a.laz, b.laz ... in these systems; "" = none.
std::string describe_datums(const std::vector<std::string>& systems) {
    std::vector<pointcloud::PointCloudInfo> infos(systems.size());
    for (std::size_t i = 0; i < systems.size(); ++i) {
        infos[i].path = std::string(1, static_cast<char>('a' + i)) + ".laz";
        if (!systems[i].empty())
            infos[i].crs = geo::Crs::from_text(systems[i]);
    }
    const Warnings warnings;
    voxelize::warn_of_mixed_datums(infos);
    return warnings.text();
}

}  // namespace

TEST_CASE("files whose heights can be compared are not warned of",
          "[voxelserver][voxelize][datums]") {
    CHECK(describe_datums({}).empty());
    CHECK(describe_datums({"", ""}).empty());
    CHECK(describe_datums({"EPSG:2154+5720", "EPSG:2154+5720"}).empty());
    CHECK(describe_datums({"EPSG:2154+5720", "EPSG:2154", ""})
              .empty());  // nothing is said of the others
    CHECK(describe_datums({"EPSG:6339+5703", "EPSG:6339+6360"})
              .empty());  // metres and feet from one datum
    CHECK(describe_datums({"EPSG:2154+5720", "EPSG:32631+5720"}).empty());  // places are converted
}

TEST_CASE("files whose heights are from different datums are warned of in one line that names both",
          "[voxelserver][voxelize][datums]") {
    const std::string text = describe_datums(
        {"EPSG:2154", "EPSG:2154+5720", "EPSG:2154+5720", "EPSG:2154+5721", "EPSG:2154+5720"});
    CHECK(std::count(text.begin(), text.end(), '\n') == 1);
    CHECK_THAT(text, contains("b.laz from '") && contains("IGN69'") && contains("d.laz from '") &&
                         contains("IGN78"));
    CHECK_THAT(text, !contains("a.laz") && !contains("c.laz") && !contains("e.laz"));
    CHECK_THAT(describe_datums({"EPSG:4979", "EPSG:4326+5773"}),
               contains("a.laz from 'ellipsoid'") && contains("EGM96"));
    const std::string many =
        describe_datums({"EPSG:2154+5720", "EPSG:2154+5721", "EPSG:2154+5703", "EPSG:2154+5773",
                         "EPSG:2154+3855", "EPSG:2154+5782"});
    CHECK_THAT(many, contains("d.laz") && !contains("e.laz") && contains(" and 2 more"));
}
