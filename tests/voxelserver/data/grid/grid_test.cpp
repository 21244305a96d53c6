// What the names of files state, by the naming rules of the sources.
#include <fstream>

#include "common/geo/crs.hpp"
#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "voxelserver/data/grid/frame.hpp"
#include "voxelserver/data/grid/square_names.hpp"

using namespace terravox;
using namespace terravox::test;
using grid::SquareNames;

TEST_CASE("names of the sources' files state squares and CRSs", "[voxelserver][grid][names]") {
    struct Case {
        const char* file;
        const char* source;  ///< "" = the name states no square
        const char* crs;
        double west;
        double south;
    };
    const auto c = GENERATE(values<Case>({
        {"TM_462_101.laz", "si-lss", "EPSG:3794", 462000, 101000},
        {"folder/tm_462_101.las", "si-lss", "EPSG:3794", 462000, 101000},
        {"GK_462_101.laz", "si-lss-d48", "EPSG:3912", 462000, 101000},
        {"AHN5_C_085000_446000.COPC.LAZ", "nl-ahn", "EPSG:28992", 85000, 446000},
        {"AHN6_2025_C_085000_446000.COPC.LAZ", "nl-ahn6", "EPSG:28992", 85000, 446000},
        {"3dm_32_350_5645_1_nw.laz", "de-nw", "EPSG:25832", 350000, 5645000},
        {"462_101.laz", "", "", 0, 0},  // of any country
        {"TM_462.laz", "", "", 0, 0},
        {"TM_462_101_cut.laz", "", "", 0, 0},
        {"TM_462_12345678901234567890.laz", "", "", 0, 0},
        {"TM__101.laz", "", "", 0, 0},
        {"", "", "", 0, 0},
    }));
    DYNAMIC_SECTION("'" << c.file << "'") {
        const auto square = SquareNames::load(util::config_dir() / "sources").find_square(c.file);
        REQUIRE(square.has_value() == !std::string(c.source).empty());
        if (!square)
            return;
        CHECK(square->source == c.source);
        CHECK(square->crs == c.crs);
        CHECK(square->west == c.west);
        CHECK(square->south == c.south);
        CHECK(square->east == c.west + 1000);
        CHECK(square->north == c.south + 1000);
    }
}

TEST_CASE("an image is named like a square with or without the letters before its numbers",
          "[voxelserver][grid][names]") {
    const auto names = SquareNames::load(util::config_dir() / "sources");
    const auto square = names.find_square("TM_462_101.laz");
    REQUIRE(square);
    CHECK(grid::is_named_like("photos/462_101.png", *square));
    CHECK(grid::is_named_like("TM_462_101.jpg", *square));
    CHECK(grid::is_named_like("tm_462_101.JPG", *square));
    CHECK_FALSE(grid::is_named_like("462_102.png", *square));
    CHECK_FALSE(grid::is_named_like("GK_462_101.png", *square));
    CHECK_FALSE(grid::is_named_like("462_101_old.png", *square));
}

TEST_CASE("a name that fits sources in two CRSs states none", "[voxelserver][grid][names]") {
    const TemporaryFolder folder;
    for (const auto& [id, crs] : {std::pair{"a", "EPSG:3794"}, {"b", "EPSG:3912"}})
        std::ofstream(folder.path() / (std::string(id) + ".toml"))
            << "id = '" << id << "'\ncrs = '" << crs
            << "'\nsquare_m = 500\n[access]\nurls = ['https://x.org/S_{N}_{E}.laz']\n";
    CHECK_FALSE(SquareNames::load(folder.path()).find_square("S_101_462.laz"));
    std::filesystem::remove(folder.path() / "b.toml");
    const auto square = SquareNames::load(folder.path()).find_square("S_101_462.laz");
    REQUIRE(square);
    CHECK(square->west == 462000);
    CHECK(square->north == 101500);
}

TEST_CASE("a damaged source file is named", "[voxelserver][grid][names]") {
    const TemporaryFolder folder;
    std::ofstream(folder.path() / "bad.toml") << "id = [";
    CHECK_THROWS_AS(SquareNames::load(folder.path()), util::UsageError);
    CHECK(!SquareNames::load(folder.path() / "absent").find_square("TM_462_101.laz"));
}

TEST_CASE("data in degrees are drawn in the UTM zone of their middle", "[voxelserver][grid]") {
    struct Case {
        const char* name;
        double lon_deg;
        double lat_deg;
        const char* crs;
    };
    const auto c = GENERATE(values<Case>({
        {"Ljubljana", 14.5, 46.05, "EPSG:32633"},
        {"Quito", -78.5, -0.2, "EPSG:32717"},
        {"the date line", 180, 10, "EPSG:32660"},
        {"beyond the date line", 180.1, 10, "EPSG:32601"},
        {"longitudes from 0 to 360", 346, 46, "EPSG:32628"},
    }));
    DYNAMIC_SECTION(c.name) {
        const geo::Crs degrees = geo::Crs::from_text("EPSG:4326");
        CHECK(grid::voxel_crs_for(degrees, c.lon_deg, c.lat_deg).wkt() ==
              geo::Crs::from_text(c.crs).wkt());
    }
}

TEST_CASE("data in metres are drawn in their own system", "[voxelserver][grid]") {
    const geo::Crs metres = geo::Crs::from_text("EPSG:3794");
    CHECK(grid::voxel_crs_for(metres, 462500, 101500).wkt() == metres.wkt());
}

TEST_CASE("metres in a system of degrees are refused", "[voxelserver][grid]") {
    const geo::Crs degrees = geo::Crs::from_text("EPSG:4326");
    for (const auto& [x, y] :
         {std::pair{462500.0, 101500.0}, std::pair{14.5, 101.0}, std::pair{-190.0, 46.0}}) {
        CHECK_THROWS_AS(grid::voxel_crs_for(degrees, x, y), util::UsageError);
        CHECK_THROWS_WITH(grid::voxel_crs_for(degrees, x, y),
                          contains("has degrees, but the middle of the data is") &&
                              contains("allowed: --crs with the system in metres"));
    }
}

TEST_CASE("a raster in degrees lies within one turn", "[voxelserver][grid]") {
    struct Case {
        const char* name;
        double west;
        double north;
        double cell;
        int width;
        bool fits;
    };
    const auto c = GENERATE(values<Case>({
        {"at Greenwich", -1, 51, 0.01, 200, true},
        {"the Earth from -180", -180, 90, 1, 360, true},
        {"the Earth from 0", 0, 90, 1, 360, true},
        {"with middles on the last meridian and the pole", -180.5, 90.5, 1, 361, true},
        {"across 180 degrees", 179, 10, 0.01, 200, true},
        {"more than a turn", -180, 90, 1, 500, false},
        {"before -180", -190, 10, 0.01, 200, false},
        {"beyond 360", 359, 10, 0.01, 200, false},
        {"beyond the pole", 10, 92, 0.01, 100, false},
        {"metres", 462000, 101000, 1, 100, false},
    }));
    INFO(c.name);
    const std::array<double, 6> geo{c.west, c.cell, 0, c.north, 0, -c.cell};
    CHECK(grid::fault_of_degrees(geo::Crs::from_text("EPSG:4326"), geo, c.width, 10).empty() ==
          c.fits);
    CHECK(grid::fault_of_degrees(geo::Crs::from_text("EPSG:3794"), geo, c.width, 10).empty());
}
