#include "voxelserver/data/imagery/image.hpp"

#include "tests/voxelserver/data/imagery/image_files.hpp"

using namespace terravox;
using namespace terravox::test;
using imagery::Orthophotos;
using imagery::Raster;

namespace {

/// What the images in a folder say of one column.
std::string find_column(const std::filesystem::path& path) {
    const auto f = frame();
    return column_text(Orthophotos({path}, f).read(voxel_x(f, 10), voxel_z(f, 10), 1, 1), 0, 0);
}

int by_band(int, int, int band) {
    return 40 * (band + 1);
}  // 40, 80, 120, 160

}  // namespace

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
        {"grey.tif", 1, "40,40,40 -"},
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
        if (std::string(c.file) == "rgba.tif")
            image.value = [](int, int, int band) { return band == 3 ? 255 : by_band(0, 0, band); };
        write_image(folder.path() / c.file, image);
        CHECK(find_column(folder.path()) == c.expected);
    }
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
