#include "raytracer/core/output/image_writer.hpp"

#include <gdal.h>
#include <ogr_srs_api.h>

#include <cstring>
#include <fstream>
#include <memory>
#include <optional>

#include "common/geo/crs.hpp"
#include "common/geo/gdal.hpp"
#include "common/util/error.hpp"
#include "raytracer/core/output/develop.hpp"
#include "tests/catch.hpp"
#include "tests/common/full_disk.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/raytracer/core/output/picture_reader.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

struct Close {
    void operator()(GDALDatasetH d) const noexcept { GDALClose(d); }
};
using Dataset = std::unique_ptr<void, Close>;

Dataset open(const std::filesystem::path& file) {
    geo::start_gdal();
    Dataset out(GDALOpen(file.string().c_str(), GA_ReadOnly));
    if (!out)
        throw std::runtime_error("GDAL does not read " + file.string());
    return out;
}

output::PictureInfo bled_info() {
    output::PictureInfo info;
    info.metadata = {{"Software", "terravox test"},
                     {"Copyright", "ARSO, CC BY 4.0: Geoportal, Škofja Loka"},
                     {"terravox:holes", "3"}};
    info.geo = output::GeoPlacement{{430'000, 0.5, 0, 137'000, 0, -0.5},
                                    geo::Crs::from_text("EPSG:3794").wkt()};
    return info;
}

/// The right half shows nothing of the world.
output::Film make_half(int width, int height) {
    output::Film film(width, height);
    tiles::TileResult all = synthetic_tile(0, 0, width, height, false);
    std::size_t i = 0;
    all.tile.each_pixel([&](int x, int) { all.samples[i++].alpha = 2 * x < width ? 1 : 0; });
    film.add(all);
    return film;
}

template <class T>
std::vector<T> band(GDALDatasetH d, int number, GDALDataType type) {
    std::vector<T> out(static_cast<std::size_t>(GDALGetRasterXSize(d)) *
                       static_cast<std::size_t>(GDALGetRasterYSize(d)));
    REQUIRE(GDALRasterIO(GDALGetRasterBand(d, number), GF_Read, 0, 0, GDALGetRasterXSize(d),
                         GDALGetRasterYSize(d), out.data(), GDALGetRasterXSize(d),
                         GDALGetRasterYSize(d), type, 0, 0) == CE_None);
    return out;
}

}  // namespace

TEST_CASE("a GeoTIFF lies where it was taken, with overviews, and is clear where the world ends",
          "[raytracer][output][geotiff]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "bled.tif";
    constexpr int kWidth = 1300;
    constexpr int kHeight = 700;
    const output::Film film = make_half(kWidth, kHeight);
    output::PictureInfo info = bled_info();
    info.exposure_ev = -0.5;
    info.tone = core::ToneCurve::kAgx;
    output::write_image(film, file, info);
    CHECK(entries_in(folder.path()) == 1);

    const Dataset d = open(file);
    REQUIRE(GDALGetRasterXSize(d.get()) == kWidth);
    REQUIRE(GDALGetRasterYSize(d.get()) == kHeight);
    REQUIRE(GDALGetRasterCount(d.get()) == 4);
    std::array<double, 6> t{};
    REQUIRE(GDALGetGeoTransform(d.get(), t.data()) == CE_None);
    const auto corner = [&](double x, double y) {
        return std::array<double, 2>{t[0] + x * t[1] + y * t[2], t[3] + x * t[4] + y * t[5]};
    };
    CHECK(corner(0, 0) == std::array<double, 2>{430'000, 137'000});
    CHECK(corner(kWidth, kHeight) == std::array<double, 2>{430'650, 136'650});
    const char* code = OSRGetAuthorityCode(GDALGetSpatialRef(d.get()), nullptr);
    REQUIRE(code != nullptr);
    CHECK(std::string(code) == "3794");
    CHECK(GDALGetOverviewCount(GDALGetRasterBand(d.get(), 1)) >= 1);
    int block_width = 0;
    int block_height = 0;
    GDALGetBlockSize(GDALGetRasterBand(d.get(), 1), &block_width, &block_height);
    CHECK(block_width == 512);
    CHECK(block_height == 512);
    const auto structure = [&](const char* name) {
        const char* v = GDALGetMetadataItem(d.get(), name, "IMAGE_STRUCTURE");
        return std::string(v != nullptr ? v : "");
    };
    CHECK(structure("COMPRESSION") == "DEFLATE");
    if (GDALGetDriverByName("COG") != nullptr)
        CHECK(structure("LAYOUT") == "COG");
    const auto item = [&](const char* name) {
        const char* v = GDALGetMetadataItem(d.get(), name, nullptr);
        return std::string(v != nullptr ? v : "");
    };
    CHECK(item("TIFFTAG_COPYRIGHT") == info.metadata[1].second);
    CHECK(item("TIFFTAG_SOFTWARE") == "terravox test");
    CHECK(item("terravox_holes") == "3");
    CHECK(item("AREA_OR_POINT") == "Area");

    CHECK(GDALGetRasterColorInterpretation(GDALGetRasterBand(d.get(), 4)) == GCI_AlphaBand);
    const auto red = band<std::uint8_t>(d.get(), 1, GDT_Byte);
    const auto blue = band<std::uint8_t>(d.get(), 3, GDT_Byte);
    const auto alpha = band<std::uint8_t>(d.get(), 4, GDT_Byte);
    int wrong = 0;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const auto i = static_cast<std::size_t>(y) * kWidth + static_cast<std::size_t>(x);
            const auto bytes = output::dithered_bytes(
                output::develop(film.at(x, y).colour, info.exposure_ev, info.tone), x, y);
            wrong +=
                red[i] == bytes[0] && blue[i] == bytes[2] && alpha[i] == (2 * x < kWidth ? 255 : 0)
                    ? 0
                    : 1;
        }
    CHECK(wrong == 0);
}

TEST_CASE("a GeoTIFF of floats keeps the light to the last bit", "[raytracer][output][geotiff]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "bled.tiff";
    const output::Film film = make_half(150, 90);
    output::PictureInfo info = bled_info();
    info.tiff_samples = core::TiffSamples::kFloat;
    output::write_image(film, file, info);
    const Dataset d = open(file);
    REQUIRE(GDALGetRasterDataType(GDALGetRasterBand(d.get(), 1)) == GDT_Float32);
    const auto green = band<float>(d.get(), 2, GDT_Float32);
    const auto alpha = band<float>(d.get(), 4, GDT_Float32);
    int wrong = 0;
    for (std::size_t i = 0; i < green.size(); ++i)
        wrong +=
            same_bits(green[i], film.samples()[i].colour.g) && alpha[i] == film.samples()[i].alpha
                ? 0
                : 1;
    CHECK(wrong == 0);
}

TEST_CASE("the alpha of a TIFF of floats has been multiplied into its light, that of bytes has not",
          "[raytracer][output]") {
    const TemporaryFolder folder;
    output::PictureInfo info;
    // Ref: TIFF 6.0, ExtraSamples: 1 for alpha that was multiplied into the colours, 2 for other.
    const auto extra_samples = [&](const char* name) {
        const auto file = folder.path() / name;
        output::write_image(make_half(15, 9), file, info);
        std::ifstream in(file, std::ios::binary);
        const std::string bytes(std::istreambuf_iterator<char>(in), {});
        const auto number = [&](std::size_t at, std::size_t size) {
            std::uint32_t out = 0;
            std::memcpy(&out, &bytes.at(at), size);
            return out;
        };
        const std::size_t directory = number(4, 4);
        for (std::size_t i = 0; i < number(directory, 2); ++i)
            if (const std::size_t field = directory + 2 + 12 * i; number(field, 2) == 338)
                return number(field + 8, 2);
        return 0U;
    };
    CHECK(extra_samples("floats.tif") == 1);
    info = bled_info();
    CHECK(extra_samples("bytes.tif") == 2);
}

TEST_CASE("what cannot become a GeoTIFF is said in one line, and an older file stays whole",
          "[raytracer][output][geotiff]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "bled.tif";
    std::ofstream(file) << "older";
    output::PictureInfo info = bled_info();
    const output::Film film = make_half(400, 300);
    output::write_image(film, folder.path() / "whole.tif", info);
    const auto whole = static_cast<rlim_t>(std::filesystem::file_size(folder.path() / "whole.tif"));
    std::filesystem::remove(folder.path() / "whole.tif");
    // GDAL writes the last 64 KiB when it closes the file, and does not say when that fails.
    const auto room = GENERATE_COPY(values<std::optional<rlim_t>>(
        {std::nullopt, rlim_t{20'000}, whole / 2, whole - 1000, whole - 1}));
    if (!room)
        info.geo->crs_wkt = "PROJCS[\"no such thing";
    std::string said;
    std::optional<FullDisk> disk;
    if (room)
        disk.emplace(*room);
    try {
        output::write_image(film, file, info);
    } catch (const util::Error& e) {
        said = e.what();
    }
    disk.reset();
    CHECK_THAT(said, contains("write the picture") && contains("bled.tif"));
    CHECK(said.find('\n') == std::string::npos);
    CHECK(entries_in(folder.path()) == 1);
    std::ifstream in(file, std::ios::binary);
    CHECK((std::string(std::istreambuf_iterator<char>(in), {}) == "older"));
}
