// Heights above different datums in one world.
#include <algorithm>
#include <filesystem>

#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/data/store/warnings.hpp"
#include "voxelserver/make/voxelize/points/file_crs.hpp"
#include "voxelserver/make/voxelize/points/options.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

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

TEST_CASE("a world has the name of its input, or of the folder in which its inputs lie",
          "[voxelserver][voxelize]") {
    const test::TemporaryFolder folder;
    const fs::path valley = folder.path() / "valley v1.5";
    fs::create_directories(valley / "east");
    struct Case {
        const char* name;
        std::vector<fs::path> files;
        const char* title;
    };
    for (const Case& c : {
             Case{"a file", {valley / "castle.copc.laz"}, "castle.copc"},
             Case{"a folder", {valley}, "valley v1.5"},
             Case{"a folder with a slash", {valley / ""}, "valley v1.5"},
             Case{"a folder by way of another", {valley / "east" / ".."}, "valley v1.5"},
             Case{"two files",
                  {valley / "TM_462_101.laz", valley / "TM_462_102.laz"},
                  "valley v1.5"},
             Case{"files of two folders",
                  {valley / "a.laz", valley / "east" / "b.laz", valley / "c.laz"},
                  "a and 2 more"},
         }) {
        INFO(c.name);
        voxelize::LidarWorldOptions options;
        options.files = c.files;
        CHECK(voxelize::world_title(options) == c.title);
        options.title = "given";
        CHECK(voxelize::world_title(options) == "given");
    }
}
