#include <numbers>
#include <random>

#include "common/geo/gdal.hpp"
#include "common/util/error.hpp"
#include "tests/common/content.hpp"
#include "tests/voxelserver/data/imagery/image_files.hpp"
#include "tests/voxelserver/data/store/warnings.hpp"
#include "voxelserver/data/imagery/image.hpp"

using namespace terravox;
using namespace terravox::test;
using imagery::Orthophotos;
using imagery::Raster;
namespace fs = std::filesystem;

namespace {

/// Opens an image and reads all of it. @return how it went
std::string try_all(const fs::path& file) {
    const auto f = frame();
    try {
        const Orthophotos photos({file}, f);
        for (int i = 0; i < 4; ++i)
            (void)photos.read(voxel_x(f, 0) + i % 2 * 150, voxel_z(f, 300) + i / 2 * 150, 150, 150);
        return "read";
    } catch (const util::Error& e) {
        if (std::string(e.what()).find(file.filename().string()) == std::string::npos)
            return std::string("the error does not name the file: ") + e.what();
        if (std::string(e.what()).find('\n') != std::string::npos)
            return std::string("more than one line: ") + e.what();
        return "refused";
    }
}

/// What the images in a folder say of one column.
std::string find_column(const std::filesystem::path& path) {
    const auto f = frame();
    return column_text(Orthophotos({path}, f).read(voxel_x(f, 10), voxel_z(f, 10), 1, 1), 0, 0);
}

int by_band(int, int, int band) {
    return 40 * (band + 1);
}  // 40, 80, 120, 160

}  // namespace

TEST_CASE("an image that cannot be placed or read is refused, naming it",
          "[voxelserver][imagery][bad]") {
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "image.tif";
    SECTION("no such file") {
        CHECK_THROWS_WITH(Orthophotos({file}, frame()), contains("image.tif"));
    }
    SECTION("no image") {
        write_content(file, "no image");
        CHECK_THROWS_WITH(Orthophotos({file}, frame()),
                          contains("image.tif") && contains("no raster that can be read"));
    }
    SECTION("no place") {
        geo::start_gdal();
        GDALDatasetUniquePtr(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
            file.string().c_str(), 4, 4, 3, GDT_Byte, nullptr));
        CHECK_THROWS_WITH(Orthophotos({file}, frame()),
                          contains("image.tif") && contains("not georeferenced"));
    }
    SECTION("a place without size") {
        ImageFile image;
        image.geo = {kEast0, 1, 1, kNorth0, 1, 1};
        write_image(file, image);
        CHECK_THROWS_WITH(Orthophotos({file}, frame()),
                          contains("image.tif") && contains("size of its pixels"));
    }
    SECTION("too many pixels to a voxel") {
        ImageFile image;
        image.geo = {kEast0, 1e-4, 0, kNorth0, 0, -1e-4};
        write_image(file, image);
        CHECK_THROWS_WITH(Orthophotos({file}, frame()),
                          contains("image.tif") && contains("allowed: up to 4096"));
    }
    SECTION("one block of 40000 x 40000 pixels") {
        ImageFile image;
        image.width = image.height = 64;
        image.options = {"BLOCKYSIZE=64"};
        write_image(file, image);
        std::string bytes = read_content(file);
        // Entries of the directory (12 bytes: tag, type, count, value): ImageWidth, ImageLength,
        // RowsPerStrip become 40000.
        int changed = 0;
        for (std::size_t i = 8; i + 12 <= bytes.size() && i < 400; ++i) {
            const auto tag = static_cast<unsigned char>(bytes[i]) |
                             static_cast<unsigned char>(bytes[i + 1]) << 8;
            if ((tag == 256 || tag == 257 || tag == 278) && bytes[i + 2] == 3 &&
                bytes[i + 3] == 0 && bytes[i + 4] == 1 && bytes[i + 8] == 64) {
                bytes[i + 8] = static_cast<char>(40000 & 255);
                bytes[i + 9] = static_cast<char>(40000 >> 8);
                ++changed;
            }
        }
        REQUIRE(changed == 3);
        write_content(file, bytes);
        CHECK(try_all(file) == "refused");
    }
}

TEST_CASE("an image cut short or with flipped bytes is read or refused",
          "[voxelserver][imagery][bad]") {
    const TemporaryFolder folder;
    const fs::path whole = folder.path() / "whole.tif";
    const fs::path file = folder.path() / "damaged.tif";
    ImageFile image;
    image.width = image.height = 200;
    image.geo = {kEast0, 1, 0, kNorth0 + 300, 0, -1};
    image.value = noise;
    const auto compression = GENERATE(std::string("COMPRESS=DEFLATE"), std::string("COMPRESS=LZW"),
                                      std::string("COMPRESS=NONE"));
    image.options = {compression, "TILED=YES", "BLOCKXSIZE=64", "BLOCKYSIZE=64"};
    INFO(image.options[0]);
    write_image(whole, image);
    const std::string bytes = read_content(whole);
    int refused = 0;
    for (int i = 1; i <= 20; ++i) {
        std::string part = bytes;
        if (i % 2 == 0)
            part.resize(bytes.size() * static_cast<std::size_t>(i) / 21);
        else
            for (int j = 0; j < 40; ++j) {  // the first half of them in the directory
                const auto where = static_cast<std::size_t>(noise(i, j, 1) * 256 + noise(i, j, 2)) %
                                   (i < 10 ? 600 : part.size());
                part[where] = static_cast<char>(part[where] ^ (1 + noise(i, j, 3) % 255));
            }
        write_content(file, part);
        const std::string result = try_all(file);
        INFO("damage " << i);
        CHECK((result == "read" || result == "refused"));
        refused += result == "refused";
    }
    CHECK(refused > 5);
}

TEST_CASE("a column reads the same in whatever rectangle it is requested",
          "[voxelserver][imagery][ortho][property]") {
    struct Case {
        const char* name;
        double pixel_m;
        double voxel_m;
        double turned_deg;
        const char* crs;
        bool gaps;
    };
    const auto c = GENERATE(values<Case>({
        {"0.2 m with gaps", 0.2, 1, 0, kCrs, true},
        {"0.37 m", 0.37, 1, 0, kCrs, false},
        {"1 m off the voxels", 1, 1, 0, kCrs, false},
        {"2.5 m", 2.5, 1, 0, kCrs, true},
        {"0.5 m, voxels of 0.25 m", 0.5, 0.25, 0, kCrs, false},
        {"0.3 m, voxels of 4 m", 0.3, 4, 0, kCrs, false},
        {"turned by 17 degrees", 0.4, 1, 17, kCrs, true},
        {"turned, coarse", 2, 1, -40, kCrs, false},
        {"another system", 0.3, 1, 0, "EPSG:32631", false},
        {"another system, coarse", 1.7, 1, 0, "EPSG:3857", true},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        double x0 = kEast0 + 120;
        double y0 = kNorth0 + 120;
        geo::Transform(geo::Crs::from_text(kCrs), geo::Crs::from_text(c.crs))
            .apply({&x0, 1}, {&y0, 1});
        const double a = c.turned_deg * std::numbers::pi / 180;
        const double s = std::sin(a) * c.pixel_m;
        const double k = std::cos(a) * c.pixel_m;
        ImageFile image;
        image.width = static_cast<int>(180 / c.pixel_m);
        image.height = static_cast<int>(150 / c.pixel_m);
        image.crs = c.crs;
        image.geo = {x0 - 90 * std::cos(a) + 75 * std::sin(a) + 0.123, k,  -s,
                     y0 + 90 * std::sin(a) + 75 * std::cos(a) + 0.077, -s, -k};
        image.options = {"TILED=YES", "BLOCKXSIZE=64", "BLOCKYSIZE=64"};
        image.value = [](int x, int y, int band) { return noise(x, y, band) | 1; };
        if (c.gaps) {
            image.nodata = 0;
            image.value = [](int x, int y, int band) {
                return noise(x / 5, y / 7, 9) < 60 ? 0 : noise(x, y, band) | 1;
            };
        }
        write_image(folder.path() / "a.tif", image);
        const auto f = frame(c.voxel_m);
        const Orthophotos photos({folder.path()}, f);
        const int side = static_cast<int>(240 / c.voxel_m);
        const auto zx = voxel_x(f, 0);
        const auto zz = voxel_z(f, 240);
        const Raster whole = photos.read(zx, zz, side, side);
        REQUIRE(!whole.empty());
        int known = 0;
        for (const auto flag : whole.flags)
            known += flag != 0;
        CHECK(known > side * side / 8);
        CHECK(known < side * side);

        const auto seed = GENERATE(take(1, random(0U, 1'000'000U)));
        INFO("seed " << seed);
        std::mt19937 random_numbers(seed);
        const auto pick = [&](int least, int most) {
            return std::uniform_int_distribution<int>(least, most)(random_numbers);
        };
        for (int i = 0; i < 60; ++i) {
            const int w = i % 5 == 0 ? 1 : pick(1, 90);
            const int h = i % 7 == 0 ? 1 : pick(1, 90);
            const int x = pick(-20, side - 1);
            const int z = pick(-20, side - 1);
            const Raster part = photos.read(zx + x, zz + z, w, h);
            for (int dz = 0; dz < h; ++dz)
                for (int dx = 0; dx < w; ++dx) {
                    if (x + dx < 0 || z + dz < 0 || x + dx >= side || z + dz >= side)
                        continue;
                    if (column_text(part, dx, dz) == column_text(whole, x + dx, z + dz))
                        continue;
                    INFO("rectangle " << x << " " << z << " " << w << " x " << h << ", column "
                                      << x + dx << " " << z + dz);
                    REQUIRE(column_text(part, dx, dz) == column_text(whole, x + dx, z + dz));
                }
        }
    }
}

TEST_CASE("near infrared is found by the file's metadata, by its name, or as a fourth band",
          "[voxelserver][imagery][bands]") {
    constexpr auto kNone = GCI_Undefined;
    const std::vector<GDALColorInterp> says_nothing{kNone, kNone, kNone, kNone};
    const auto rgb_and = [](GDALColorInterp fourth) {
        return std::vector{GCI_RedBand, GCI_GreenBand, GCI_BlueBand, fourth};
    };
    struct Case {
        const char* file;
        int bands;
        const char* expected;
        std::vector<GDALColorInterp> meanings = {};
        std::vector<std::string> descriptions = {};
    };
    const auto c = GENERATE_COPY(values<Case>({
        {"ortho.tif", 3, "40,80,120 -"},
        {"ortho_irc_2021.tif", 3, "- 40/80"},
        {"BDORTHO-CIR.TIF", 3, "- 40/80"},
        {"circle.tif", 3, "40,80,120 -"},  // no CIR
        {"rgbx.tif", 4, "40,80,120 160/40", rgb_and(kNone)},
        {"rgba.tif", 4, "40,80,120 -", rgb_and(GCI_AlphaBand)},
        {"dop_rgbi_1.tif", 4, "40,80,120 160/40", rgb_and(GCI_AlphaBand)},  // its name counts
        {"x.tif", 4, "80,120,160 40/80", says_nothing, {"nir", "red", "green", "blue"}},
        {"y.tif", 3, "- 40/80", says_nothing, {"Near Infrared", "Red", "Green"}},
        {"s2.tif", 3, "120,80,40 -", says_nothing, {"B02 (blue)", "B03 (green)", "B04 (red)"}},
        {"b.tif", 3, "120,80,40 -", says_nothing, {"B02", "B03", "B04"}},
        {"tm.tif", 4, "40,80,120 -", says_nothing, {"B1", "B2", "B3", "B4"}},  // an old Landsat
        {"words.tif", 3, "120,80,40 -", says_nothing, {"blue band", "Green band", "RED"}},
        {"r.tif", 4, "160,120,40 80/160", says_nothing, {"B", "NIR", "G", "R"}},
        {"edge.tif", 4, "80,120,160 -", says_nothing, {"red edge", "red", "green", "blue"}},
        {"green_i.tif", 4, "40,120,160 -", says_nothing, {"red", "green_i", "green", "blue"}},
        {"tags.tif", 3, "120,80,40 -", rgb_and(kNone), {"blue", "green", "red"}},
        {"two.tif", 4, "40,80,120 -", says_nothing, {"red", "green", "blue", "red"}},
        {"none.tif", 3, "40,80,120 -", says_nothing, {"Band 1", "Band 2", "Band 3"}},
        {"grey.tif", 1, "40,40,40 -"},
        {"two_bands.tif", 2, "40,40,40 -", {GCI_GrayIndex, kNone}},
        {"palette.tif", 1, "215,40,77 -"},
        // Alpha 80 of 255: mostly see-through.
        {"greya.tif", 2, "- -", {GCI_GrayIndex, GCI_AlphaBand}},
    }));
    DYNAMIC_SECTION(c.file) {
        const TemporaryFolder folder;
        ImageFile image;
        image.bands = c.bands;
        image.descriptions = c.descriptions;
        image.meanings = c.meanings;
        image.value = by_band;
        image.palette = std::string(c.file) == "palette.tif";
        if (std::string(c.file) == "rgba.tif")
            image.value = [](int, int, int band) { return band == 3 ? 255 : by_band(0, 0, band); };
        write_image(folder.path() / c.file, image);
        CHECK(find_column(folder.path()) == c.expected);
    }
}

TEST_CASE("a warning says what a file says of its bands and is not followed",
          "[voxelserver][imagery][bands]") {
    struct Case {
        std::vector<std::string> descriptions;
        const char* warning;
    };
    const auto c = GENERATE(values<Case>({
        {{"red", "green", "blue"}, ""},
        {{"blue", "green", "red"}, "band 3 is named 'red', but tagged blue; it is taken for red"},
        {{"red", "Red", "blue"}, "bands 1 and 2 are both named red; the first is taken"},
        {{"Blue", "", ""}, "band 1 is named 'Blue'; it is taken for red"},
        {{"red", "NIR", "SWIR"}, "band 2 is named 'NIR'; it is taken for green"},
        {{"red", "green", "SWIR 1"}, "band 3 is named 'SWIR 1'; it is taken for blue"},
        {{"NIR", "red", "green"}, ""},
        {{"NIR"}, "band 1 is near infrared alone; it is taken for grey"},
        {{"pan"}, ""},
    }));
    const TemporaryFolder folder;
    ImageFile image;
    image.descriptions = c.descriptions;
    image.bands = static_cast<int>(c.descriptions.size());
    if (image.bands > 1 && (c.descriptions[0] == "NIR" || c.descriptions[1].empty()))
        image.meanings = {GCI_Undefined, GCI_Undefined, GCI_Undefined};
    write_image(folder.path() / "a.tif", image);
    const Warnings warnings;
    (void)find_column(folder.path());
    if (*c.warning == '\0')
        CHECK(warnings.text().empty());
    else
        CHECK_THAT(warnings.text(), contains(c.warning));
}

TEST_CASE(
    "colour and near infrared of two images come together, with the red that belongs to the near "
    "infrared",
    "[voxelserver][imagery][bands]") {
    const TemporaryFolder folder;
    ImageFile image;
    image.value = by_band;
    write_image(folder.path() / "rgb.tif", image);
    image.value = [](int, int, int band) { return 200 + band; };
    write_image(folder.path() / "irc.tif", image);
    CHECK(find_column(folder.path()) == "40,80,120 200/201");
}
