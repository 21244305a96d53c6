#include "voxelserver/data/pointcloud/formats/files.hpp"

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/data/ply/ply_bytes.hpp"
#include "voxelserver/data/lidar/las_writer.hpp"
#include "voxelserver/data/pointcloud/formats/open.hpp"

using namespace terravox;
using namespace terravox::pointcloud;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

const std::string kMesh = "ply\nformat ascii 1.0\nelement vertex 3\nelement face 1\nend_header\n";
const std::string kCloud =
    "ply\nformat ascii 1.0\nelement vertex 1\nproperty double x\nproperty double y\n"
    "property double z\nelement face 0\nend_header\n1 2 3\n";

void write_las(const fs::path& file) {
    lidar::LasWriter writer(file, {});
    lidar::LasWritePoint point;
    point.x = 1;
    point.y = 2;
    point.z = 3;
    writer.write(point);
    writer.close();
}

}  // namespace

TEST_CASE("a file is one of points by its first bytes or its ending", "[voxelserver][pointcloud]") {
    struct Case {
        const char* name;
        const char* file;
        std::string bytes;
        bool named;
        bool in_folder;
    };
    const auto c = GENERATE(values<Case>({
        {"LAS", "a.las", "LASF", true, true},
        {"a damaged LAZ", "A.LAZ", "nothing", true, true},
        {"LAS by another name", "a.bin", "LASF", true, false},
        {"PLY", "a.ply", kCloud, true, true},
        {"PLY by another name", "a.bin", kCloud, true, false},
        {"a damaged PLY", "a.PLY", "nothing", true, true},
        {"a mesh", "a.ply", kMesh, true, false},
        {"a text", "a.txt", "no points", false, false},
        {"an empty text", "a.txt", "", false, false},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        write_content(folder.path() / c.file, c.bytes);
        CHECK(is_point_file(folder.path() / c.file) == c.named);
        CHECK(is_point_file_of_folder(folder.path() / c.file) == c.in_folder);
    }
}

TEST_CASE("folders are replaced by their point files, without meshes",
          "[voxelserver][pointcloud]") {
    const TemporaryFolder folder;
    for (const char* name : {"b.laz", "a.ply", "notes.txt"})
        write_content(folder.path() / name, name);
    write_content(folder.path() / "mesh.ply", kMesh);
    CHECK(expand_point_files({folder.path()}) ==
          std::vector<fs::path>{folder.path() / "a.ply", folder.path() / "b.laz"});
    CHECK(expand_point_files({folder.path() / "mesh.ply"}).size() == 1);
    fs::create_directory(folder.path() / "empty");
    CHECK_THROWS_WITH(expand_point_files({folder.path() / "empty"}),
                      contains("the folder holds none of .las .laz .ply"));
}

TEST_CASE("each format opens its own files", "[voxelserver][pointcloud]") {
    const TemporaryFolder folder;
    write_las(folder.path() / "a.laz");
    write_content(folder.path() / "b.ply", kCloud);
    for (const char* name : {"a.laz", "b.ply"}) {
        const auto source = open_point_source(folder.path() / name);
        CHECK(source->info().path == folder.path() / name);
        CHECK(source->info().point_count == 1);
        const auto sample = source->sample(10);
        REQUIRE(sample.size() == 1);
        CHECK(sample[0].y == 2);
        CHECK(source->spatial_index() == nullptr);
    }
}

TEST_CASE("what cannot be opened is refused with the reason", "[voxelserver][pointcloud]") {
    struct Case {
        const char* name;
        const char* file;
        std::string bytes;  ///< "" = there is no file
        const char* said;
    };
    const auto c = GENERATE(values<Case>({
        {"no file", "a.laz", "", "no such file"},
        {"no file of any format", "a.bin", "", "no such file"},
        {"a mesh", "a.ply", kMesh, "a mesh of 1 faces"},
        {"a text", "a.txt", "no points", "allowed: LAS, LAZ or COPC, PLY"},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        if (!c.bytes.empty())
            write_content(folder.path() / c.file, c.bytes);
        CHECK_THROWS_WITH(open_point_source(folder.path() / c.file), contains(c.said));
        CHECK_THROWS_AS(open_point_source(folder.path() / c.file), util::Error);
    }
}

TEST_CASE("the file next to a PLY that names its CRS belongs to it", "[voxelserver][pointcloud]") {
    const TemporaryFolder folder;
    write_content(folder.path() / "a.ply", kCloud);
    CHECK(find_side_file(folder.path() / "a.ply") == std::nullopt);
    write_content(folder.path() / "a.prj", "");
    CHECK(find_side_file(folder.path() / "a.ply") == folder.path() / "a.prj");
    write_content(folder.path() / "a.laz", "LASF");
    CHECK(find_side_file(folder.path() / "a.laz") == std::nullopt);
}
