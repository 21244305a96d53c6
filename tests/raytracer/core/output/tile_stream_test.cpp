#include "raytracer/core/output/tile_stream.hpp"

#include <gdal.h>

#include <algorithm>
#include <fstream>
#include <memory>
#include <random>

#include "common/geo/crs.hpp"
#include "common/geo/gdal.hpp"
#include "common/util/error.hpp"
#include "raytracer/core/output/develop.hpp"
#include "raytracer/core/output/image_writer.hpp"
#include "raytracer/core/tiles/tile_plan.hpp"
#include "tests/catch.hpp"
#include "tests/common/emulated.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/raytracer/core/output/picture_reader.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;
using namespace std::string_literals;

namespace {

output::PictureInfo some_info() {
    output::PictureInfo info;
    info.metadata = {
        {"Software", "terravox test"},
        {"Copyright", "ARSO"},
        // Like the attribute whose value is known last; headers list attributes by their names.
        {"ImageDescription", "terravox:holes\0string\0................"s}};
    info.square_names = {"462_101", "463_101"};
    info.tone = core::ToneCurve::kFilmic;
    return info;
}

/// The tiles of a single pass, in an order of chance.
std::vector<tiles::RenderTile> shuffled_tiles(const output::StreamShape& s, unsigned seed) {
    auto tiles =
        tiles::plan_tiles(s.width_px, s.height_px, 1, s.tile_px, core::TileOrder::kRows).front();
    std::shuffle(tiles.begin(), tiles.end(), std::mt19937(seed));
    return tiles;
}

tiles::TileResult synthetic(const tiles::RenderTile& t, bool with_layers) {
    tiles::TileResult out = synthetic_tile(t.x0, t.y0, t.x1, t.y1, with_layers);
    out.tile = t;
    return out;
}

/// Memory that is this process's own now, bytes.
std::uint64_t own_memory() {
    std::ifstream in("/proc/self/status");
    std::string word;
    std::uint64_t kib = 0;
    while (in >> word)
        if (word == "RssAnon:")
            in >> kib;
    return kib * 1024;
}

}  // namespace

TEST_CASE("a streamed EXR holds what a film's would, whatever the order of its tiles",
          "[raytracer][output][stream]") {
    struct Case {
        const char* name;
        output::StreamShape shape;
    };
    const auto c = GENERATE(values<Case>({{"small odd tiles", {203, 101, 33, false}},
                                          {"all layers", {150, 90, 32, true}},
                                          {"parts of tiles", {560, 270, 514, false}},
                                          {"one tile", {40, 30, 64, true}}}));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        const auto whole = folder.path() / "whole.exr";
        const auto streamed = folder.path() / "streamed.exr";
        const output::StreamShape& s = c.shape;
        output::Film film(s.width_px, s.height_px, s.with_layers);
        output::TileStream stream(streamed, s, some_info());
        for (const tiles::RenderTile& tile : shuffled_tiles(s, 3)) {
            const tiles::TileResult result = synthetic(tile, s.with_layers);
            for (output::TileSink* sink :
                 {static_cast<output::TileSink*>(&film), static_cast<output::TileSink*>(&stream)})
                sink->add(result);
        }
        CHECK_FALSE(fs::exists(streamed));
        stream.finish(1234);
        output::write_image(film, whole, some_info());
        const PictureFile a = read_picture(whole);
        const PictureFile b = read_picture(streamed);
        REQUIRE(a.names() == b.names());
        CHECK(std::memcmp(a.pixels.data(), b.pixels.data(), a.pixels.size() * sizeof(float)) == 0);
        const ExrHeader header(streamed);
        CHECK(header.tiled);
        CHECK(header.attributes.at("lineOrder").value == std::string(1, '\2'));  // random
        CHECK(header.attributes.at("terravox:holes").value == "000000001234");
        CHECK(header.attributes.at("owner").value == "ARSO");
        CHECK(header.attributes.at("comments").value ==
              "terravox:holes\\x00string\\x00................");
        CHECK(entries_in(folder.path()) == 2);
    }
}

TEST_CASE(
    "a streamed TIFF is a BigTIFF with the film's pixels, and lies on Earth where it has a place",
    "[raytracer][output][stream][geotiff]") {
    struct Case {
        const char* name;
        bool geo;
        core::TiffSamples samples;
        bool floats;
    };
    using enum core::TiffSamples;
    const auto c = GENERATE(values<Case>({{"plain", false, kAuto, true},
                                          {"plain bytes", false, kByte, false},
                                          {"on Earth", true, kAuto, false},
                                          {"on Earth, floats", true, kFloat, true}}));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        const auto file = folder.path() / "streamed.tif";
        const output::StreamShape s{500, 300, 48, false};
        output::PictureInfo info = some_info();
        info.tiff_samples = c.samples;
        if (c.geo)
            info.geo = output::GeoPlacement{{430'000, 0.5, 0, 137'000, 0, -0.5},
                                            geo::Crs::from_text("EPSG:3794").wkt()};
        output::TileStream stream(file, s, info);
        for (const tiles::RenderTile& tile : shuffled_tiles(s, 4))
            stream.add(synthetic(tile, false));
        stream.finish(7);
        CHECK(entries_in(folder.path()) == 1);
        std::ifstream in(file, std::ios::binary);
        std::array<char, 4> magic{};
        in.read(magic.data(), 4);
        CHECK(magic == std::array<char, 4>{'I', 'I', 43, 0});
        const std::unique_ptr<void, void (*)(GDALDatasetH)> d(
            GDALOpen(file.string().c_str(), GA_ReadOnly),
            [](GDALDatasetH h) { (void)GDALClose(h); });
        REQUIRE(d != nullptr);
        std::array<double, 6> transform{};
        CHECK((GDALGetGeoTransform(d.get(), transform.data()) == CE_None) == c.geo);
        if (c.geo)
            CHECK(transform[3] == 137'000);
        CHECK((GDALGetRasterDataType(GDALGetRasterBand(d.get(), 1)) == GDT_Float32) == c.floats);
        CHECK(std::string(GDALGetMetadataItem(d.get(), "terravox_holes", nullptr)) == "7");
        std::vector<float> pixels(static_cast<std::size_t>(s.width_px) *
                                  static_cast<std::size_t>(s.height_px) * 4);
        REQUIRE(GDALDatasetRasterIOEx(d.get(), GF_Read, 0, 0, s.width_px, s.height_px,
                                      pixels.data(), s.width_px, s.height_px, GDT_Float32, 4,
                                      nullptr, 16, 16 * s.width_px, 4, nullptr) == CE_None);
        const tiles::TileResult all = synthetic_tile(0, 0, s.width_px, s.height_px, false);
        const output::Developer developed(info.exposure_ev, info.tone);
        int wrong = 0;
        for (int y = 0; y < s.height_px; ++y)
            for (int x = 0; x < s.width_px; ++x) {
                const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(s.width_px) +
                               static_cast<std::size_t>(x);
                const tiles::PixelSample& p = all.samples[i];
                const auto bytes = output::dithered_bytes(developed(p.colour), x, y);
                wrong += same_bits(pixels[4 * i + 1],
                                   c.floats ? p.colour.g : static_cast<float>(bytes[1]))
                             ? 0
                             : 1;
                wrong += same_bits(pixels[4 * i + 3],
                                   c.floats ? p.alpha : std::floor(p.alpha * 255 + 0.5f))
                             ? 0
                             : 1;
            }
        CHECK(wrong == 0);
    }
}

// A sanitizer's own memory grows with what a program touches, or has freed.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST_CASE("memory stays flat while a picture streams", "[raytracer][output][stream][all]") {
    if (test::emulated()) {
        WARN("not tried: an emulator keeps what it has translated in the program's memory");
        return;
    }
    const std::string ending = GENERATE(".exr", ".tif");
    INFO(ending);
    geo::limit_gdal_cache(std::int64_t{16} << 20);
    const TemporaryFolder folder;
    const output::StreamShape s{4096, 4096, 64, false};
    constexpr std::uint64_t kGrowth_bytes = std::uint64_t{48} << 20;  // 3 bytes a pixel
    REQUIRE(output::Film::bytes(s.width_px, s.height_px, false) > 6 * kGrowth_bytes);
    output::TileStream stream(folder.path() / ("large" + ending), s, some_info());
    tiles::TileResult result = synthetic_tile(0, 0, 64, 64, false);
    std::uint64_t first = 0;
    std::uint64_t most = 0;
    for (const tiles::RenderTile& tile : shuffled_tiles(s, 5)) {
        result.tile = tile;
        stream.add(result);
        most = std::max(most, own_memory());
        if (first == 0)
            first = most;
    }
    stream.finish(0);
    CHECK(std::max(most, own_memory()) - first < kGrowth_bytes);
    geo::limit_gdal_cache(geo::kGdalCache_bytes);
}
#endif

TEST_CASE("errors of a stream are reported, and no file is left behind",
          "[raytracer][output][stream]") {
    const TemporaryFolder folder;
    const output::StreamShape s{100, 60, 32, false};
    const auto file = folder.path() / "streamed.exr";
    const auto tiles = shuffled_tiles(s, 6);
    {
        output::TileStream stream(file, s, some_info());
        stream.add(synthetic(tiles[0], false));
        CHECK_THROWS_WITH(stream.add(synthetic(tiles[0], false)), contains("came twice"));
        tiles::RenderTile coarse = tiles[1];
        coarse.step = 2;
        CHECK_THROWS_WITH(stream.add(synthetic(coarse, false)), contains("single pass"));
        tiles::RenderTile shifted = tiles[1];
        ++shifted.x0;
        CHECK_THROWS_WITH(stream.add(synthetic(shifted, false)), contains("single pass"));
        tiles::TileResult poor = synthetic(tiles[1], false);
        poor.samples.pop_back();
        CHECK_THROWS_AS(stream.add(poor), util::Error);
        CHECK_THROWS_WITH(stream.finish(0), contains("tiles are missing"));
    }
    CHECK(entries_in(folder.path()) == 0);
    const std::string small = GENERATE("picture.png", "picture.jpg", "picture.PNG");
    CHECK_THROWS_AS(output::check_can_stream(folder.path() / small, s), util::UsageError);
    CHECK_THROWS_WITH(output::check_can_stream(folder.path() / small, s),
                      contains(".exr .tif") && contains("100x60"));
    CHECK_THROWS_WITH(output::TileStream(folder.path() / "a.tif", {100, 60, 33, false}, {}),
                      contains("multiples of 16"));
    CHECK(entries_in(folder.path()) == 0);
}

TEST_CASE("a picture streams when its film would not fit", "[raytracer][output][stream]") {
    const output::StreamShape s{1000, 1000, 64, false};
    const output::StreamShape layered{1000, 1000, 64, true};
    const std::uint64_t bytes = output::Film::bytes(1000, 1000, false);
    CHECK_FALSE(output::must_stream(s, bytes));
    CHECK(output::must_stream(s, bytes - 1));
    CHECK(output::must_stream(layered, bytes));
}

TEST_CASE("tiles of the file fill the tiles of the plan", "[raytracer][output][stream]") {
    struct Case {
        int tile_px;
        int multiple_of;
        int expected;
    };
    for (const Case c : {Case{64, 1, 64},
                         {64, 16, 64},
                         {33, 1, 33},
                         {33, 16, 0},
                         {1, 1, 1},
                         {4096, 16, 512},
                         {1024, 1, 512},
                         {1021, 1, 1021},
                         {1021, 16, 0},
                         {720, 16, 240},
                         {48, 16, 48},
                         {16, 16, 16}}) {
        INFO(c.tile_px << " by " << c.multiple_of);
        CHECK(output::file_tile_px(c.tile_px, c.multiple_of) == c.expected);
    }
}
