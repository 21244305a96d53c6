#include <fstream>

#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/imagery/one_colour.hpp"
#include "voxelserver/imagery/image_identity.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

voxel::Fingerprint identity(const fs::path& file) {
    return imagery::image_identity(file);
}

void write(const fs::path& file, const std::string& text) {
    std::ofstream(file) << text;
}

}  // namespace

TEST_CASE("an image has another identity when the files next to it change",
          "[voxelserver][imagery][identity]") {
    struct Case {
        const char* beside;
        bool other;
    };
    const auto c = GENERATE(values<Case>({{"a.tfw", true},
                                          {"a.tifw", true},
                                          {"a.wld", true},
                                          {"a.TFW", true},
                                          {"a.tif.aux.xml", true},
                                          {"a.tif.ovr", true},
                                          {"a.tif.msk", true},
                                          {"a.prj", true},
                                          {"b.tfw", false},
                                          {"a.txt", false}}));
    DYNAMIC_SECTION(c.beside) {
        const TemporaryFolder folder;
        const fs::path file = folder.path() / "a.tif";
        write_one_colour(file, 770'000, 6'277'000, 10, 10, {1, 2, 3});
        const auto before = identity(file);
        CHECK((identity(file) == before));
        write(folder.path() / c.beside, "1");
        const auto with = identity(file);
        CHECK((with != before) == c.other);
        write(folder.path() / c.beside, "22");
        CHECK((identity(file) != with) == c.other);
    }
}

TEST_CASE("an image stays what it is in another folder", "[voxelserver][imagery][identity]") {
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "a.tif";
    const fs::path moved = folder.path() / "elsewhere" / "b.tif";
    write_one_colour(file, 770'000, 6'277'000, 10, 10, {1, 2, 3});
    const auto before = identity(file);
    fs::create_directories(moved.parent_path());
    fs::rename(file, moved);
    CHECK((identity(moved) == before));
    CHECK_THROWS(identity(file));
}

TEST_CASE("a virtual image is another when an image that it is made of is",
          "[voxelserver][imagery][identity]") {
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "a.tif";
    const fs::path vrt = folder.path() / "all.vrt";
    write_one_colour(file, 770'000, 6'277'000, 10, 10, {1, 2, 3});
    write(vrt,
          "<VRTDataset rasterXSize=\"10\" rasterYSize=\"10\"><GeoTransform>770000, 1, 0, 6277010, "
          "0, -1</GeoTransform>"
          "<VRTRasterBand dataType=\"Byte\" band=\"1\"><SimpleSource><SourceFilename "
          "relativeToVRT=\"1\">a.tif</SourceFilename>"
          "<SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>");
    const auto before = identity(vrt);
    CHECK((identity(vrt) == before));
    write_one_colour(file, 770'000, 6'277'000, 10, 10, {1, 2, 4});
    CHECK((identity(vrt) != before));
}
