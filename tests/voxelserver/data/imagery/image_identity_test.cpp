#include <gdal_priv.h>
#include <random>
#include <string>
#include <vector>

#include "common/geo/gdal.hpp"
#include "tests/catch.hpp"
#include "tests/common/content.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/image_file.hpp"
#include "voxelserver/data/imagery/image_files.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

voxel::Fingerprint identity(const fs::path& file) {
    return imagery::image_identity(file);
}

constexpr std::size_t kMany = 4096;

std::vector<fs::path> sources(const std::string& text, std::size_t most = kMany) {
    return imagery::vrt_sources(text, "/vrt", most);
}

std::string band(const std::string& source) {
    return "<VRTRasterBand dataType=\"Byte\" band=\"1\"><SimpleSource>" + source +
           "<SourceBand>1</SourceBand></SimpleSource></VRTRasterBand>";
}

std::string make_vrt(const std::string& inside) {
    return "<VRTDataset rasterXSize=\"10\" rasterYSize=\"10\"><GeoTransform>770000, 1, 0, 6277010, "
           "0, -1</GeoTransform>" +
           inside + "</VRTDataset>";
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
        write_one_colour(file, 0, 0, 10, 10, {1, 2, 3});
        const auto before = identity(file);
        CHECK((identity(file) == before));
        write_content(folder.path() / c.beside, "1");
        const auto with = identity(file);
        CHECK((with != before) == c.other);
        write_content(folder.path() / c.beside, "22");
        CHECK((identity(file) != with) == c.other);
    }
}

TEST_CASE("an image stays what it is in another folder", "[voxelserver][imagery][identity]") {
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "a.tif";
    const fs::path moved = folder.path() / "elsewhere" / "b.tif";
    write_one_colour(file, 0, 0, 10, 10, {1, 2, 3});
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
    write_one_colour(file, 0, 0, 10, 10, {1, 2, 3});
    write_content(vrt,
                  make_vrt(band("<SourceFilename relativeToVRT=\"1\">a.tif</SourceFilename>")));
    const auto before = identity(vrt);
    CHECK((identity(vrt) == before));
    write_one_colour(file, 0, 0, 10, 10, {1, 2, 4});
    CHECK((identity(vrt) != before));
}

TEST_CASE("a virtual image names its sources", "[voxelserver][imagery][vrt]") {
    struct Case {
        const char* text;  ///< SOURCE stands for SourceFilename
        std::vector<fs::path> files;
    };
    const auto c = GENERATE(values<Case>({
        {R"(<SOURCE relativeToVRT="1">a.tif</SOURCE>)", {"/vrt/a.tif"}},
        {R"(<SOURCE relativeToVRT = '1' >a.tif</SOURCE>)", {"/vrt/a.tif"}},
        {R"(<SOURCE relativeToVRT="0">/x/a.tif</SOURCE>)", {"/x/a.tif"}},
        {R"(<SOURCE relativeToVRT="0">x/a.tif</SOURCE>)", {"x/a.tif"}},
        {"<SOURCE>/x/a.tif</SOURCE>", {"/x/a.tif"}},
        {R"(<SOURCE relativeToVRT="1">/x/a.tif</SOURCE>)", {"/x/a.tif"}},
        {R"(<SOURCE shared="0" a="x=1" relativeToVRT="1" b=''>a.tif</SOURCE>)", {"/vrt/a.tif"}},
        {R"(<sourcefilename RELATIVETOVRT="1">a.tif</sourcefilename>)", {"/vrt/a.tif"}},
        {R"(<SourceDataset relativeToVRT="1">a.tif</SourceDataset>)", {"/vrt/a.tif"}},
        {"<SOURCE>\n  /x/a b.tif\t</SOURCE>", {"/x/a b.tif"}},
        {"<SOURCE>/x/&lt;a&amp;b&gt;&quot;&apos;&#65;&#x42;&#xfc;&#x20AC;&#x1F600;.tif</SOURCE>",
         {"/x/<a&b>\"'AB\xc3\xbc\xe2\x82\xac\xf0\x9f\x98\x80.tif"}},
        {"<SOURCE>/x/a&b &nbsp; &#; &#xg; &#1114112; &#0;&.tif</SOURCE>",
         {"/x/a&b &nbsp; &#; &#xg; &#1114112; &#0;&.tif"}},
        {"<SOURCE>/b</SOURCE><SOURCE>/a</SOURCE><SOURCE>/b</SOURCE>", {"/b", "/a"}},
        {"<SOURCE></SOURCE><SOURCE/> <SOURCE> </SOURCE>", {}},
        {"<SOURCEs>/a</SOURCEs><SourceBand>/a</SourceBand><Source>/a</Source>", {}},
        {"<SOURCE>/a</SOURCE><SOURCE>/b", {"/a"}},
        {"<SOURCE relativeToVRT=\"1", {}},
        {"<SOURCE relativeToVRT=\"1>a.tif</SOURCE>", {"a.tif"}},
        {"\x89PNG < > <<SOURCE", {}},
        {"", {}},
    }));
    const std::string text = replaced(c.text, "SOURCE", "SourceFilename");
    INFO(text);
    CHECK(sources(text) == c.files);
}

TEST_CASE("a virtual image names no more sources than wanted", "[voxelserver][imagery][vrt]") {
    std::string text;
    for (int i = 0; i < 20; ++i)
        text += "<SourceFilename>/" + std::to_string(i) + "</SourceFilename>";
    CHECK(sources(text).size() == 20);
    CHECK(sources(text, 7).size() == 7);
    CHECK(sources(text, 0).empty());
}

TEST_CASE("long texts without an end are read in one go", "[voxelserver][imagery][vrt]") {
    const char* part =
        GENERATE("<SourceFilename ", "<SourceFilename>", "<SourceFilename a=\"", "&", "<",
                 "<SourceFilename>&#", "<SourceFilename relativeToVRT=\"1\">x<");
    std::string text;
    while (text.size() < (std::size_t{4} << 20))
        text += part;
    CHECK(sources(text).size() <= 1);
    CHECK(sources(text + ">").size() <= 1);
}

TEST_CASE("damaged virtual images name something or nothing", "[voxelserver][imagery][vrt]") {
    const std::string good = make_vrt(
        band("<SourceFilename relativeToVRT=\"1\" shared='0'>a&amp;b&#x20;c.tif</SourceFilename>"));
    REQUIRE(sources(good) == std::vector<fs::path>{"/vrt/a&b c.tif"});
    std::mt19937 random(12);
    int found = 0;
    for (int i = 0; i < 5'000; ++i) {
        std::string bad = good.substr(0, random() % 4 == 0 ? random() % good.size() : good.size());
        for (unsigned n = random() % 4; n > 0 && !bad.empty(); --n)
            bad[random() % bad.size()] = static_cast<char>(random() % 256);
        INFO(bad);
        const auto files = sources(bad);
        CHECK(files.size() <= 1);
        for (const fs::path& file : files)
            CHECK(!file.empty());
        found += static_cast<int>(files.size());
    }
    CHECK(found > 250);
}
