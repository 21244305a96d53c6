#include "raytracer/apps/pmtiles/map_tiles.hpp"

#include <cpl_conv.h>
#include <ogr_srs_api.h>

#include <array>
#include <atomic>
#include <cmath>
#include <fstream>
#include <iterator>
#include <numbers>

#include "common/geo/crs.hpp"
#include "common/util/error.hpp"
#include "raytracer/core/output/gdal_writing.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/raytracer/apps/pmtiles/archive_reader.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

using map::Rgba8;

constexpr int kWidth = 1200;
constexpr int kHeight = 800;
constexpr double kCell_m = 0.5;
constexpr std::array<Rgba8, 4> kQuarters = {
    {{200, 20, 20, 255}, {20, 200, 20, 255}, {20, 20, 200, 255}, {0, 0, 0, 0}}};

struct Place {
    const char* crs;
    double west;
    double north;
};

/// A map of four quarters, row by row: red, green, blue, and nothing.
void write_quarters(const std::filesystem::path& file, const Place& place, int bands = 4) {
    const output::GdalWatch watch("write a map of four quarters");
    const output::GdalDataset out(GDALCreate(GDALGetDriverByName("GTiff"), file.string().c_str(),
                                             kWidth, kHeight, bands, GDT_Byte, nullptr));
    watch.check(out != nullptr);
    std::array<double, 6> transform = {place.west, kCell_m, 0, place.north, 0, -kCell_m};
    GDALSetGeoTransform(out.get(), transform.data());
    if (*place.crs != '\0') {
        const auto crs = OSRNewSpatialReference(nullptr);
        OSRSetFromUserInput(crs, place.crs);
        GDALSetSpatialRef(out.get(), crs);
        OSRDestroySpatialReference(crs);
    }
    std::vector<Rgba8> pixels;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
            pixels.push_back(
                kQuarters[static_cast<std::size_t>(2 * (2 * y / kHeight) + 2 * x / kWidth)]);
    watch.check(GDALDatasetRasterIOEx(out.get(), GF_Write, 0, 0, kWidth, kHeight, pixels.data(),
                                      kWidth, kHeight, GDT_Byte, bands, nullptr, 4,
                                      GSpacing{4} * kWidth, 1, nullptr) == CE_None);
    if (bands == 4)
        GDALSetRasterColorInterpretation(GDALGetRasterBand(out.get(), 4), GCI_AlphaBand);
}

constexpr Place kLoka{"EPSG:3794", 462'000, 101'500};

output::GeoPlacement make_placement(const Place& place) {
    const std::string crs = *place.crs == '\0' ? "" : geo::Crs::from_text(place.crs).wkt();
    return {{place.west, kCell_m, 0, place.north, 0, -kCell_m}, crs};
}

pmtiles::WebArea make_area(const Place& place, int tile_px = 256) {
    return pmtiles::to_web_area(make_placement(place), kWidth, kHeight, tile_px, "test");
}

/// The pixel of Web Mercator at a place, by the formulas that web pages use.
Rgba8 pixel_at(const pmtiles::TileCutter& cutter, int zoom, double easting, double northing,
               std::uint32_t edge = 256) {
    const geo::LatLon at = geo::to_lat_lon(geo::Crs::from_text(kLoka.crs), easting, northing);
    const double side = std::ldexp(static_cast<double>(edge), zoom);
    const double x = (at.lon_deg + 180) / 360 * side;
    const double lat = at.lat_deg * std::numbers::pi / 180;
    const double y =
        (1 - std::log(std::tan(lat) + 1 / std::cos(lat)) / std::numbers::pi) / 2 * side;
    const auto column = static_cast<std::uint32_t>(x);
    const auto row = static_cast<std::uint32_t>(y);
    const auto pixels = cutter.cut({zoom, column / edge, row / edge});
    return pixels.empty() ? Rgba8{} : pixels[row % edge * edge + column % edge];
}

bool never() {
    return false;
}

}  // namespace

TEST_CASE("tiles show what lies at their place on Earth", "[pmtiles]") {
    const TemporaryFolder folder;
    const std::filesystem::path file = folder.path() / "map.tif";
    write_quarters(file, kLoka);
    const pmtiles::TileCutter cutter(file, 256, "test");
    const pmtiles::WebArea area = make_area(kLoka);
    // 0.5 m at 46 degrees north, where Web Mercator is stretched by 1.44: 0.41 m at zoom 18.
    CHECK(area.max_zoom == 18);
    // The longer side, 600 m, has 45 pixels there.
    CHECK(area.min_zoom == 13);
    for (int zoom = area.min_zoom; zoom <= area.max_zoom; ++zoom) {
        INFO("zoom " << zoom);
        for (std::size_t quarter = 0; quarter < 4; ++quarter) {
            const double across = quarter % 2 == 0 ? 0.25 : 0.75;
            const double down = quarter < 2 ? 0.25 : 0.75;
            CHECK(pixel_at(cutter, zoom, kLoka.west + across * kWidth * kCell_m,
                           kLoka.north - down * kHeight * kCell_m) == kQuarters[quarter]);
        }
    }
    // Two cells away from a border of two colours, each has its own.
    const double middle = kLoka.west + kWidth * kCell_m / 2;
    const double north = kLoka.north - 50 * kCell_m;
    CHECK(pixel_at(cutter, 18, middle - 3 * kCell_m, north) == kQuarters[0]);
    CHECK(pixel_at(cutter, 18, middle + 3 * kCell_m, north) == kQuarters[1]);
    const auto [west, south, east, top] = area.bounds_deg();
    const geo::LatLon corner =
        geo::to_lat_lon(geo::Crs::from_text(kLoka.crs), kLoka.west, kLoka.north);
    CHECK(west == Approx(corner.lon_deg).margin(1e-4));
    CHECK(top == Approx(corner.lat_deg).margin(1e-4));
    CHECK(east > west);
    CHECK(south < top);
}

TEST_CASE("the tiles of a map do not depend on threads, and those without anything are left out",
          "[pmtiles]") {
    const TemporaryFolder folder;
    const std::filesystem::path map = folder.path() / "map.tif";
    write_quarters(map, kLoka);
    const auto format = GENERATE(pmtiles::TileFormat::kPng, pmtiles::TileFormat::kWebp);
    std::vector<std::string> files;
    for (const int threads : {1, 4}) {
        const std::filesystem::path file = folder.path() / (std::to_string(threads) + ".pmtiles");
        const std::uint64_t count =
            pmtiles::write_map_tiles(map, make_area(kLoka), file, format,
                                     {"A <map>", "by <b>them</b>", 3}, threads, true, never);
        files.push_back(read_all_bytes(file));
        const ArchiveReader archive(files.back());
        CHECK(archive.tiles().size() == count);
        std::size_t rectangle = 0;
        for (int zoom = make_area(kLoka).min_zoom; zoom <= make_area(kLoka).max_zoom; ++zoom)
            rectangle += make_area(kLoka).tiles(zoom).size();
        CHECK(count < rectangle);
        CHECK(count > rectangle / 2);
        const char* const begins = format == pmtiles::TileFormat::kPng ? "\x89PNG" : "RIFF";
        for (const auto& [id, tile] : archive.tiles())
            CHECK(tile.substr(0, 4) == begins);
        CHECK(archive.metadata().find(R"("attribution":"by <b>them</b>")") != std::string::npos);
        CHECK(archive.metadata().find(R"("holes":3)") != std::string::npos);
    }
    CHECK(files[0] == files[1]);
}

TEST_CASE("tiles of 512 pixels show the same, one zoom earlier", "[pmtiles]") {
    const TemporaryFolder folder;
    const std::filesystem::path file = folder.path() / "map.tif";
    write_quarters(file, kLoka);
    const pmtiles::TileCutter cutter(file, 512, "test");
    const pmtiles::WebArea area = make_area(kLoka, 512);
    CHECK(area.max_zoom == make_area(kLoka).max_zoom - 1);
    CHECK(area.min_zoom == make_area(kLoka).min_zoom - 1);
    CHECK(area.bounds == make_area(kLoka).bounds);
    for (const int zoom : {area.min_zoom, area.max_zoom})
        for (std::size_t quarter = 0; quarter < 4; ++quarter) {
            INFO("zoom " << zoom << ", quarter " << quarter);
            const double east = kLoka.west + (quarter % 2 == 0 ? 0.25 : 0.75) * kWidth * kCell_m;
            const double north = kLoka.north - (quarter < 2 ? 0.25 : 0.75) * kHeight * kCell_m;
            CHECK(pixel_at(cutter, zoom, east, north, 512) == kQuarters[quarter]);
        }
}

TEST_CASE("zooms that are chosen lie within those of the map", "[pmtiles]") {
    pmtiles::WebArea area = make_area(kLoka);
    const int max_zoom = area.max_zoom;
    for (const auto& [first, last] : {std::pair{-1, 3}, std::pair{5, 4}, std::pair{3, 19}}) {
        INFO(first << " to " << last);
        CHECK_THROWS_AS(area.choose_zooms(first, last, "test"), util::UsageError);
        CHECK(area.max_zoom == max_zoom);
    }
    area.choose_zooms(4, 9, "test");
    CHECK(area.min_zoom == 4);
    CHECK(area.max_zoom == 9);
    CHECK(area.tiles(4).size() == 1);
}

TEST_CASE("maps that Web Mercator has no place for are refused", "[pmtiles]") {
    const auto [place, said] =
        GENERATE(std::pair{Place{"", 0, 0}, "no place on Earth"},
                 std::pair{Place{"EPSG:3413", -100, 100}, "85 degrees"},
                 // Fiji, where 180 degrees are at easting 819,110 m.
                 std::pair{Place{"EPSG:32760", 818'900, 8'096'000}, "180 degrees east"});
    INFO(place.crs);
    CHECK_THROWS_WITH(make_area(place), test::contains(said));
}

TEST_CASE("zooms are as fine as the map", "[pmtiles]") {
    const auto [edge_m, zoom] =
        GENERATE(std::pair{0.05, 21}, std::pair{0.5, 18}, std::pair{1.0, 17}, std::pair{1.4, 17},
                 std::pair{10.0, 14});
    output::GeoPlacement placement = make_placement(kLoka);
    placement.transform[1] = edge_m;
    placement.transform[5] = -edge_m;
    INFO(edge_m);
    const pmtiles::WebArea area = pmtiles::to_web_area(placement, kWidth, kHeight, 256, "test");
    CHECK(area.max_zoom == zoom);
    // Metres of the ground.
    const double pixel_m =
        156'543.034 * std::cos(46.05 * std::numbers::pi / 180) / std::ldexp(1.0, area.max_zoom);
    CHECK(pixel_m <= 1.11 * edge_m);
    CHECK(2 * pixel_m > 1.1 * edge_m);
}

TEST_CASE("files that are no maps are refused", "[pmtiles]") {
    const TemporaryFolder folder;
    const std::filesystem::path file = folder.path() / "map.tif";
    SECTION("without alpha") {
        write_quarters(file, kLoka, 3);
    }
    SECTION("no picture") {
        std::ofstream(file) << "text";
    }
    CHECK_THROWS_AS(pmtiles::write_map_tiles(file, make_area(kLoka), folder.path() / "map.pmtiles",
                                             pmtiles::TileFormat::kPng, {}, 1, true, never),
                    util::Error);
    CHECK_FALSE(exists(folder.path() / "map.pmtiles"));
}

TEST_CASE("a map that is interrupted leaves nothing", "[pmtiles]") {
    const TemporaryFolder folder;
    const std::filesystem::path file = folder.path() / "map.tif";
    write_quarters(file, kLoka);
    std::atomic<int> asked = 0;
    CHECK_THROWS_WITH(pmtiles::write_map_tiles(
                          file, make_area(kLoka), folder.path() / "map.pmtiles",
                          pmtiles::TileFormat::kPng, {}, 2, true, [&] { return ++asked > 3; }),
                      test::contains("interrupted"));
    CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);
}
