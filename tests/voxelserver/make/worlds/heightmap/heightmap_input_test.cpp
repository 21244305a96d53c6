#include "voxelserver/make/worlds/heightmap/heightmap_world.hpp"

#include <cmath>
#include <fstream>

#include "common/geo/raster_gate.hpp"
#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/make/worlds/heightmap/heightmap_voxels.hpp"
#include "tests/voxelserver/make/worlds/heightmap/raster_files.hpp"
#include "voxelserver/make/worlds/heightmap/height_file.hpp"

using namespace terravox;
using namespace terravox::heightmap;
using namespace terravox::voxel;
using terravox::test::contains;
using terravox::test::open;
using terravox::test::RasterSpec;
using terravox::test::Voxels;
using terravox::test::write_heights;

TEST_CASE("rasters in degrees or turned are warped as they are read", "[raytracer][heightmap]") {
    const test::TemporaryFolder folder;
    struct Case {
        const char* name;
        const char* own;
        std::array<double, 6> geo;
        const char* crs;
    };
    const auto c = GENERATE(values<Case>({
        {"degrees", "EPSG:4326", {14.5, 1e-5, 0, 46.05, 0, -1e-5}, "EPSG:32633"},
        {"degrees in the south", "EPSG:4326", {151.2, 1e-5, 0, -33.8, 0, -1e-5}, "EPSG:32756"},
        {"turned", "EPSG:3794", {460'000, 0.8, 0.6, 101'000, 0.6, -0.8}, "EPSG:3794"},
    }));
    DYNAMIC_SECTION(c.name) {
        RasterSpec spec;
        spec.crs = c.own;
        spec.geo = c.geo;
        const auto world =
            open({write_heights(folder.path() / "a.tif", spec, [](int, int) { return 250.0; })});
        CHECK(world->info().crs == c.crs);
        Voxels voxels(*world);
        const auto& b = world->info().bounds;
        CHECK(voxels.top((b.min[0] + b.max[0]) / 2, (b.min[2] + b.max[2]) / 2) == 250);
        int solid = 0;
        for (std::int32_t z = b.min[2]; z < b.max[2]; ++z)
            for (std::int32_t x = b.min[0]; x < b.max[0]; ++x)
                solid += voxels.top(x, z).has_value();
        CHECK(solid > 100 * 80 / 2);
        CHECK(solid < 100 * 80 * 3 / 2);
    }
}

TEST_CASE("south-up rasters are read as they lie", "[raytracer][heightmap]") {
    const test::TemporaryFolder folder;
    RasterSpec spec;
    spec.geo = {460'000, 1, 0, 101'000, 0, 1};
    const auto world =
        open({write_heights(folder.path() / "a.tif", spec, [](int, int y) { return 100.0 + y; })});
    Voxels voxels(*world);
    CHECK(voxels.top(460'050, -101'001) == 100);
    CHECK(voxels.top(460'050, -101'080) == 179);
}

TEST_CASE("what is no raster of heights is refused by name", "[raytracer][heightmap]") {
    const test::TemporaryFolder folder;
    const auto file = folder.path() / "a.tif";
    const auto flat = [](int, int) { return 100.0; };
    RasterSpec spec;
    SECTION("missing") {
        CHECK_THROWS_WITH(open({folder.path() / "none.tif"}), contains("none.tif: no such file"));
    }
    SECTION("text") {
        std::ofstream(file) << "nothing";
        CHECK_THROWS_WITH(open({file}), contains("a.tif: no raster"));
        CHECK(!is_height_raster(file));
    }
    SECTION("no place") {
        spec.geo = {};
        CHECK_THROWS_WITH(open({write_heights(file, spec, flat)}),
                          contains("a.tif: not georeferenced"));
    }
    SECTION("no system") {
        spec.crs.clear();
        write_heights(file, spec, flat);
        CHECK_THROWS_WITH(open({file}), contains("give one with --crs"));
        HeightmapOptions options;
        options.rasters = {file};
        options.crs = "EPSG:3794";
        CHECK(open_heightmap_world(options)->info().crs == "EPSG:3794");
    }
    SECTION("a system that names a file") {
        const auto grid = folder.path() / "a.asc";
        std::ofstream(grid) << "ncols 3\nnrows 3\nxllcorner 460000\nyllcorner 101000\ncellsize "
                               "1\n7 7 7\n7 7 7\n7 7 7\n";
        std::ofstream(folder.path() / "a.prj")
            << R"(PROJCS["a",GEOGCS["b",DATUM["c",SPHEROID["d",6378137,298.25]],)"
            << R"(PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],)"
            << R"(PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",0],)"
            << R"(PARAMETER["central_meridian",15],PARAMETER["scale_factor",0.9999],)"
            << R"(PARAMETER["false_easting",500000],PARAMETER["false_northing",-5000000],)"
            << R"(UNIT["metre",1],EXTENSION["PROJ4","+proj=tmerc +lon_0=15 +nadgrids=/a"]])";
        CHECK_THROWS_WITH(open({grid}),
                          contains("a.asc") && contains("allowed: one without names of files"));
        HeightmapOptions options;
        options.rasters = {grid};
        options.crs = "EPSG:3794";
        const auto world = open_heightmap_world(options);
        CHECK(world->info().crs == "EPSG:3794");
        CHECK(Voxels(*world).top(460'001, -101'002) == 7);
    }
    SECTION("nothing but holes") {
        spec.nodata = 100;
        CHECK_THROWS_WITH(open({write_heights(file, spec, flat)}), contains("no heights in it"));
    }
    SECTION("cells like threads") {
        spec.geo[5] = -1000;
        CHECK_THROWS_WITH(open({write_heights(file, spec, flat)}), contains("allowed: 1/16 to 16"));
    }
    SECTION("an unknown unit") {
        spec.unit = "cubits";
        CHECK_THROWS_WITH(open({write_heights(file, spec, flat)}), contains("cubits"));
    }
    SECTION("too far away for 32 bits") {
        CHECK_THROWS_WITH(open({write_heights(file, spec, flat)}, 1e-5),
                          contains("allowed: within +-2^29"));
    }
    SECTION("options") {
        CHECK_THROWS_AS(open({}), util::UsageError);
        CHECK_THROWS_AS(open({write_heights(file, spec, flat)}, 0), util::UsageError);
        CHECK(is_height_raster(file));
        HeightmapOptions options;
        options.rasters = {file};
        options.base_m = std::nan("");
        CHECK_THROWS_AS(open_heightmap_world(options), util::UsageError);
        options.base_m.reset();
        options.height_unit_m = -1;
        CHECK_THROWS_AS(open_heightmap_world(options), util::UsageError);
    }
    SECTION("a picture") {
        spec.type = GDT_Byte;
        spec.bands = 3;
        CHECK(!is_height_raster(write_heights(file, spec, flat)));
    }
}

TEST_CASE("a damaged raster is a hole where it is damaged, and nowhere else",
          "[raytracer][heightmap]") {
    const test::TemporaryFolder folder;
    RasterSpec spec;
    spec.width = 5000;
    spec.height = 5000;
    spec.type = GDT_Int16;
    spec.options = {"TILED=YES", "COMPRESS=DEFLATE"};
    spec.overviews = {8};
    const auto file = write_heights(folder.path() / "a.tif", spec,
                                    [](int x, int y) { return 100.0 + x % 7 + y % 5; });
    GDALDatasetUniquePtr data(GDALDataset::Open(file.c_str(), GDAL_OF_RASTER));
    const std::string place = data->GetRasterBand(1)->GetMetadataItem(
        "BLOCK_OFFSET_9_9", "TIFF");  // one tile of 256 x 256
    data.reset();
    {
        std::fstream out(file, std::ios::in | std::ios::out | std::ios::binary);
        out.seekp(std::stoll(place));
        for (int i = 0; i < 400; ++i)
            out.put('\x5a');
    }
    const auto world = open({file});
    const std::int32_t by = 0;
    const std::int32_t x = 460'000 + 9 * 256 + 128;
    const std::int32_t z = -101'080 + 9 * 256 + 128;
    CHECK_THROWS_WITH(world->box({0, floor_div(x, 64), by, floor_div(z, 64)}),
                      contains("a.tif: damaged"));
    CHECK_THROWS_AS(world->box({0, floor_div(x, 64), by, floor_div(z, 64)}),
                    util::Error);  // and not remembered as air
    CHECK(world->box({0, floor_div(x + 512, 64), by, floor_div(z, 64)}));
}

TEST_CASE("directories of a TIFF that lead back to themselves are not followed for ever",
          "[raytracer][heightmap]") {
    const test::TemporaryFolder folder;
    const auto file = folder.path() / "a.tif";
    {
        // 65,535 times StripOffsets, and the directory itself as the next one.
        std::ofstream out(file, std::ios::binary);
        out.write("II*\0\10\0\0\0\xff\xff", 10);
        for (int i = 0; i < 65'535; ++i)
            out.write("\x11\1\4\0\5\0\0\0\10\0\0\0", 12);
        out.write("\10\0\0\0", 4);
    }
    CHECK_FALSE(geo::find_lost_directory_of_tiff(file));
}

TEST_CASE(
    "a raster that was cut short before its last overview is refused, and read where all of it is "
    "there",
    "[raytracer][heightmap]") {
    struct Case {
        const char* name;
        std::vector<std::string> options;
        std::vector<int> overviews;
    };
    const auto c = GENERATE(values<Case>({
        {"overviews at the end", {"TILED=YES"}, {2, 4, 8}},
        {"compressed", {"TILED=YES", "COMPRESS=DEFLATE"}, {2, 4}},
        {"64 bits", {"BIGTIFF=YES"}, {2, 4}},
        {"most significant byte first", {"ENDIANNESS=BIG"}, {2}},
        {"64 bits, most significant byte first", {"BIGTIFF=YES", "ENDIANNESS=BIG"}, {2}},
        {"no overviews", {}, {}},
    }));
    DYNAMIC_SECTION(c.name) {
        const test::TemporaryFolder folder;
        RasterSpec spec;
        spec.width = spec.height = 600;
        spec.options = c.options;
        spec.overviews = c.overviews;
        const auto file = write_heights(folder.path() / "a.tif", spec,
                                        [](int x, int y) { return 100.0 + x % 7 + y % 5; });
        CHECK_NOTHROW(open({file}));
        const auto whole = std::filesystem::file_size(file);
        const int overviews = HeightFile({file, {}, {}, {}}).overviews();
        CHECK(overviews == static_cast<int>(c.overviews.size()));
        int refused = 0;
        int opened = 0;
        for (std::uintmax_t bytes = whole - 1; bytes > whole / 2; bytes -= whole / 40) {
            std::filesystem::resize_file(file, bytes);
            INFO("cut to " << bytes << " of " << whole);
            try {
                const int found = HeightFile({file, {}, {}, {}}).overviews();
                CHECK(found == overviews);  // lost cells are missed where they are read
                ++opened;
            } catch (const util::Error& e) {
                ++refused;
                CHECK_THAT(e.what(), contains("a.tif"));
            }
        }
        CHECK((refused > 0 || overviews == 0));
        CHECK(opened + refused > 5);
    }
}

TEST_CASE("heights that no overview has are an error, never cut off", "[raytracer][heightmap]") {
    const test::TemporaryFolder folder;
    RasterSpec spec;
    spec.width = 5000;
    spec.height = 5000;
    spec.type = GDT_Int16;
    spec.options = {"TILED=YES", "COMPRESS=DEFLATE"};
    spec.overviews = {64};
    const auto file = write_heights(folder.path() / "a.tif", spec, [](int x, int y) {
        return x == 2500 && y == 2500 ? 3000.0 : 100.0;
    });
    const auto world = open({file});
    CHECK(!world->info().framed.empty());
    CHECK(world->info().bounds.max[1] < 2000);
    CHECK(world->box({0, floor_div(460'100, 64), 0, floor_div(-101'000, 64)}));
    CHECK_THROWS_WITH(world->box({0, floor_div(462'500, 64), 0, floor_div(-98'580, 64)}),
                      contains("heights up to 3000"));
    CHECK_THROWS_AS(world->box({world->info().levels, 0, 0, 0}), util::UsageError);
    world->stop();
    CHECK_THROWS_WITH(world->box({0, floor_div(460'100, 64), 0, floor_div(-101'000, 64)}),
                      contains("interrupted"));
}
