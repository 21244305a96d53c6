#include "common/geo/crs.hpp"
#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "voxelserver/data/grid/frame.hpp"

using namespace terravox;
using terravox::test::contains;

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
    for (const auto& [x, y] : {std::pair{462500.0, 101500.0}, std::pair{14.5, 101.0}}) {
        CHECK_THROWS_AS(grid::voxel_crs_for(degrees, x, y), util::UsageError);
        CHECK_THROWS_WITH(grid::voxel_crs_for(degrees, x, y),
                          contains("has degrees, but the middle of the data is") &&
                              contains("allowed: --crs with the system in metres"));
    }
}
