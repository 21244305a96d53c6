#include "voxelserver/make/voxelize/points/options.hpp"

#include <filesystem>

#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
namespace fs = std::filesystem;

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
