#include "voxelserver/imagery/bands.hpp"

#include "tests/voxelserver/imagery/image_files.hpp"

using namespace terravox;
using namespace terravox::test;
using imagery::Orthophotos;
using imagery::Raster;

namespace {

/// What the images in a folder say of one column.
std::string column_of(const std::filesystem::path& path) {
    const auto f = frame();
    return column_text(Orthophotos({path}, f).read(voxel_x(f, 10), voxel_z(f, 10), 1, 1), 0, 0);
}

int by_band(int, int, int band) {
    return 40 * (band + 1);
}  // 40, 80, 120, 160

}  // namespace

TEST_CASE("near infrared is found by the file's metadata, by its name, or as a fourth band",
          "[voxelserver][imagery][bands]") {
    struct Case {
        const char* name;
        const char* file;
        int bands;
        std::vector<std::string> descriptions;
        std::vector<GDALColorInterp> meanings;
        const char* expected;
    };
    const auto c = GENERATE(values<Case>({
        {"red, green, blue", "ortho.tif", 3, {}, {}, "40,80,120 -"},
        {"the name says irc", "ortho_irc_2021.tif", 3, {}, {}, "- 40/80"},
        {"the name says CIR", "BDORTHO-CIR.TIF", 3, {}, {}, "- 40/80"},
        {"circle is no CIR", "circle.tif", 3, {}, {}, "40,80,120 -"},
        {"a fourth band that says nothing",
         "rgbx.tif",
         4,
         {},
         {GCI_RedBand, GCI_GreenBand, GCI_BlueBand, GCI_Undefined},
         "40,80,120 160/40"},
        {"a fourth band that is alpha",
         "rgba.tif",
         4,
         {},
         {GCI_RedBand, GCI_GreenBand, GCI_BlueBand, GCI_AlphaBand},
         "40,80,120 -"},
        {"tagged as alpha, but the name says rgbi",
         "dop_rgbi_1.tif",
         4,
         {},
         {GCI_RedBand, GCI_GreenBand, GCI_BlueBand, GCI_AlphaBand},
         "40,80,120 160/40"},
        {"described out of order",
         "x.tif",
         4,
         {"nir", "red", "green", "blue"},
         {GCI_Undefined, GCI_Undefined, GCI_Undefined, GCI_Undefined},
         "80,120,160 40/80"},
        {"near infrared, red and green by description",
         "y.tif",
         3,
         {"Near Infrared", "Red", "Green"},
         {GCI_Undefined, GCI_Undefined, GCI_Undefined},
         "- 40/80"},
        {"grey", "grey.tif", 1, {}, {}, "40,40,40 -"},
        {"grey with alpha",
         "greya.tif",
         2,
         {},
         {GCI_GrayIndex, GCI_AlphaBand},
         "- -"},  // alpha 80 of 255: mostly see-through
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        ImageFile image;
        image.bands = c.bands;
        image.descriptions = c.descriptions;
        image.meanings = c.meanings;
        image.value = by_band;
        if (c.bands == 4 && std::string(c.file) == "rgba.tif")
            image.value = [](int, int, int band) { return band == 3 ? 255 : by_band(0, 0, band); };
        write_image(folder.path() / c.file, image);
        CHECK(column_of(folder.path()) == c.expected);
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
    CHECK(column_of(folder.path()) == "40,80,120 200/201");
}
