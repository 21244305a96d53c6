#include "voxelserver/make/worlds/open/open_world.hpp"

#include <cstdint>
#include <filesystem>
#include <string>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/content.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using terravox::test::contains;
using terravox::test::TemporaryFolder;
using terravox::test::write_content;
namespace fs = std::filesystem;
using namespace std::string_literals;

namespace {

/// A ZIP archive of one empty file.
std::string zip_with(const std::string& name) {
    const auto number = [](std::uint32_t value, int bytes) {
        std::string out;
        for (int i = 0; i < bytes; ++i)
            out += static_cast<char>(value >> (8 * i));
        return out;
    };
    const std::string zeros(12, '\0');  // checksum and sizes
    const auto length = static_cast<std::uint32_t>(name.size());
    const std::string local = "PK\x03\x04" + number(20, 2) + number(0, 8) + zeros +
                              number(length, 2) + number(0, 2) + name;
    const std::string central = "PK\x01\x02" + number(20, 2) + number(20, 2) + number(0, 8) +
                                zeros + number(length, 2) + std::string(16, '\0') + name;
    return local + central + "PK\x05\x06" + number(0, 4) + number(1, 2) + number(1, 2) +
           number(static_cast<std::uint32_t>(central.size()), 4) +
           number(static_cast<std::uint32_t>(local.size()), 4) + number(0, 2);
}

}  // namespace

TEST_CASE("a file that is no world says what it is and what to do", "[voxelserver][worlds]") {
    const TemporaryFolder folder;
    struct Case {
        const char* name;
        const char* file;
        std::string bytes;
        const char* said;
    };
    const auto c = GENERATE(values<Case>({
        {"a ZIP of LAZ", "a.zip", zip_with("squares/a.laz"),
         "it is a ZIP archive of LAZ files; unpack it, and give the folder"},
        {"a ZIP of images", "a.zip", zip_with("a.TIF"), "a ZIP archive of GeoTIFF files; unpack"},
        {"a ZIP of something", "a.zip", zip_with("read.me"),
         "a ZIP archive without a Minecraft world; unpack it"},
        {"a ZIP by its content", "download", zip_with("a.las"), "a ZIP archive of LAS files"},
        {"half a ZIP", "a.zip", zip_with("a.laz").substr(0, 20), "a damaged ZIP archive"},
        {"another archive", "a.7z", "7z\xbc\xaf\x27\x1c and more", "a compressed file; unpack it"},
        {"a compressed file", "a.laz.gz", "\x1f\x8b and more", "a compressed file; unpack it"},
        {"a PNG", "photo.png", "\x89PNG\r\n\x1a\n", "it is an image; give it with --ortho"},
        {"a JPEG", "photo.jpg", "\xff\xd8\xff\xe0", "it is an image; give it with --ortho"},
        {"a JPEG 2000", "photo.jp2", "\0\0\0\x0cjP  \r\n"s, "it is an image"},
        {"a TIFF without heights", "photo.tif", "II*\0 and more"s, "it is an image"},
        {"Erdas Imagine", "a.img", "EHFA_HEADER_TAG\0"s,
         "a raster of a format that is not read; make a GeoTIFF of it with gdal_translate"},
        {"netCDF", "a.nc", "CDF\x01", "a raster of a format that is not read"},
        {"Surfer", "a.grd", "DSBB\x04", "a raster of a format that is not read"},
        {"a grid of text behind a mark", "a.asc", "\xef\xbb\xbfncols 4\nnrows 4\n",
         "an Esri ASCII grid behind a byte order mark; write it without the mark"},
        {"E57", "a.e57", "ASTM-E57 and more",
         "it is an E57 file; translate it: pdal translate HERE/a.e57 HERE/a.laz"},
        {"rows of numbers", "a.xyz", "462000.5 101000.5 300.1\n462001 101001 300\n",
         "a text of points; translate it: pdal translate --reader readers.text "
         "--readers.text.header=\"X Y Z\" HERE/a.xyz HERE/a.laz"},
        {"rows below their names", "a.csv", "X,Y,Z,Intensity\n462000.5,101000.5,300.1,7\n",
         "pdal translate --reader readers.text HERE/a.csv HERE/a.laz"},
        {"other points", "a.pcd", "# .PCD v0.7\n", "translate it: pdal translate HERE/a.pcd"},
        {"Esri's points", "a.zlas", "", "terravox grab convert"},
        {"a page for points", "a.dat", "<!DOCTYPE html><title>Sign in</title>",
         "it is a web page, perhaps an error of a download"},
        {"a scene", "evening.toml", "version = 1\n", "give a scene with --scene"},
        {"a list of a store", "fishnet.gpkg", "SQLite format 3", "give the store's folder"},
        {"nothing", "a.bin", "", "it is empty"},
        {"a text", "read.me", "Two words\nand two more\n", ""},
    }));
    DYNAMIC_SECTION(c.name) {
        const fs::path file = folder.path() / c.file;
        write_content(file, c.bytes);
        const std::string said = test::replaced(c.said, "HERE", folder.path().string());
        const std::string remedy = worlds::find_remedy(file.string());
        CHECK_THAT(remedy, contains(said));
        CHECK(remedy.empty() == said.empty());
    }
}

TEST_CASE("a folder that is no world says where one is", "[voxelserver][worlds]") {
    const TemporaryFolder folder;
    const fs::path top = folder.path() / "top";
    fs::create_directories(top);
    SECTION("nothing in it") {
        CHECK(worlds::find_remedy(top.string()) == "it is empty");
    }
    SECTION("squares in a folder in it") {
        write_content(top / "deep" / "er" / "a.laz", "LASF");
        CHECK(worlds::find_remedy(top.string()) ==
              "but folders in it do: " + (top / "deep" / "er").string() +
                  "; give those that belong together");
    }
    SECTION("squares in many folders") {
        for (const char* name : {"b", "a", "e", "d", "c"})
            write_content(top / name / "a.laz", "LASF");
        CHECK(worlds::find_remedy(top.string()) ==
              "but folders in it do: " + (top / "a").string() + ", " + (top / "b").string() + ", " +
                  (top / "c").string() + " and 2 more; give those that belong together");
    }
    SECTION("too deep to be looked for") {
        write_content(top / "1" / "2" / "3" / "4" / "a.laz", "LASF");
        CHECK(worlds::find_remedy(top.string()).empty());
    }
    SECTION("images") {
        write_content(top / "b.png", "\x89PNG");
        write_content(top / "a.me", "read me\nfirst\n");
        CHECK_THAT(worlds::find_remedy(top.string()),
                   contains("of its file b.png: it is an image; give it with --ortho"));
    }
    SECTION("a packed game's world") {
        write_content(top / "a.mcworld", zip_with("db/CURRENT"));
        CHECK(worlds::find_remedy(top.string()) == "but its file a.mcworld does; give that");
    }
    SECTION("ZIP archives") {
        write_content(top / "a.zip", zip_with("a.laz"));
        CHECK_THAT(worlds::find_remedy(top.string()),
                   contains("a.zip: it is a ZIP archive of LAZ"));
    }
}

TEST_CASE("a path that does not exist says what may be meant", "[voxelserver][worlds]") {
    const TemporaryFolder folder;
    fs::create_directories(folder.path() / "my_squares");
    const std::string at = folder.path().string() + "/";
    CHECK(worlds::find_remedy(at + "my_sqaures") == "did you mean " + at + "my_squares?");
    CHECK(worlds::find_remedy(at + "*.laz") == "no name fits the pattern");
    CHECK(worlds::find_remedy(at + "elsewhere").empty());
    CHECK_THAT(worlds::find_remedy("s3://bucket/a.laz"), contains("download other data first"));
    CHECK_THROWS_WITH(worlds::find_kind(at + "my_sqaures"),
                      contains("my_squares? allowed: " + worlds::allowed_inputs()));
}

TEST_CASE("the address of a file of points is no voxel server", "[voxelserver][worlds]") {
    for (const char* address :
         {"https://host/a.laz", "http://host/b/A.LAZ?token=7", "https://host/a.copc.laz",
          "https://host/a.zip", "https://host/dtm.tif#1"}) {
        INFO(address);
        CHECK_THAT(worlds::find_address_remedy(address), contains("download it first"));
        CHECK_THROWS_AS(worlds::find_kind(address), util::UsageError);
        CHECK_THROWS_WITH(worlds::find_kind(address), contains(address));
    }
    for (const char* address : {"http://host:8080", "https://host/a.tvx", "https://laz/"})
        CHECK(worlds::find_address_remedy(address).empty());
}

TEST_CASE("what the system refuses to show is told as the system tells it",
          "[voxelserver][worlds]") {
    const TemporaryFolder folder;
    const fs::path loop = folder.path() / "loop";
    fs::create_symlink(loop, loop);
    CHECK_THROWS_AS(worlds::find_kind(loop.string()), util::Error);
    CHECK_THROWS_WITH(worlds::find_kind(loop.string()),
                      contains(loop.string()) && contains("symbolic links"));
}
