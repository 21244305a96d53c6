#include "voxelserver/out/archive/stac/stac.hpp"

#include <array>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/geo/crs.hpp"
#include "common/voxel/archive/archive_writer.hpp"
#include "common/voxel/pyramid_world.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
namespace fs = std::filesystem;
using terravox::test::contains;

namespace {

/// An archive without boxes, whose world has some bounds: metres of its CRS are voxels unless it
/// says otherwise.
struct Described {
    std::string crs = "EPSG:3794";
    voxel::VoxelBounds bounds{{462'000, 200, -102'000}, {463'000, 900, -101'000}};
    double units_per_voxel = 1;
    std::string licence = {};
};

nlohmann::json to_item(const Described& what) {
    const test::TemporaryFolder folder;
    const geo::Crs crs = geo::Crs::from_text(what.crs);
    voxel::WorldInfo info;
    info.bounds = what.bounds;
    info.levels = voxel::levels_for(what.bounds);
    info.crs = crs.name();
    info.crs_wkt = crs.wkt();
    info.crs_units_per_voxel = what.units_per_voxel;
    info.licence = what.licence;
    const fs::path archive = folder.path() / "place.tvx";
    voxel::ArchiveWriter(archive, info, 0).finish();
    const auto time = stac::stac_time("2023-04-01");
    (void)stac::write_stac({{archive}, folder.path(), time, "", "", false});
    return nlohmann::json::parse(std::ifstream(folder.path() / "place.json"));
}

}  // namespace

TEST_CASE("stac: a CRS has a number of EPSG, or its text alone", "[archive][stac]") {
    CHECK(to_item({})["properties"]["proj:epsg"] == 3794);
    for (const char* const crs :
         {"EPSG:3794+8690",
          "+proj=tmerc +lat_0=0 +lon_0=15 +k=0.9999 +x_0=500000 +y_0=-5000000 +ellps=GRS80"}) {
        INFO(crs);
        Described other;
        other.crs = crs;
        const auto item = to_item(other);
        CHECK(item["properties"]["proj:epsg"].is_null());
        CHECK(item["properties"]["proj:wkt2"] == geo::Crs::from_text(crs).wkt());
        CHECK(item["bbox"][0] == Approx(to_item({})["bbox"][0].get<double>()).margin(1e-4));
    }
}

TEST_CASE("stac: boxes of a map are in its units", "[archive][stac]") {
    // Los Angeles, in feet.
    const auto item = to_item(
        {"EPSG:2229", {{1'970'000, 0, -562'000}, {1'970'500, 100, -561'000}}, 3.28083333333333});
    const auto box = item["properties"]["proj:bbox"].get<std::array<double, 4>>();
    CHECK(box[2] - box[0] == Approx(500 * 3.28083333333333));
    CHECK(box[3] - box[1] == Approx(1000 * 3.28083333333333));
    CHECK(item["bbox"][0] == Approx(-118.3).margin(0.3));
    CHECK(item["bbox"][1] == Approx(34).margin(0.3));
}

TEST_CASE("stac: licences are those of SPDX where they are known", "[archive][stac]") {
    struct Case {
        const char* licence;
        const char* wanted;
    };
    for (const Case& one :
         {Case{"", "proprietary"}, Case{"CC BY 4.0", "CC-BY-4.0"}, Case{"CC-BY-4.0", "CC-BY-4.0"},
          Case{"CC0", "CC0-1.0"}, Case{"dl-de/zero-2-0", "DL-DE-ZERO-2.0"},
          Case{"Open use, source must be given", "proprietary"}}) {
        INFO(one.licence);
        Described what;
        what.licence = one.licence;
        CHECK(to_item(what)["properties"]["license"] == one.wanted);
    }
}

TEST_CASE("stac: a place whose border is none on a map of degrees is refused", "[archive][stac]") {
    struct Case {
        const char* name;
        Described what;
    };
    const auto c = GENERATE(values<Case>({
        {"the antimeridian", {"EPSG:32601", {{160'000, 0, -10'000}, {170'000, 9, -1'000}}, 1, ""}},
        {"a pole", {"EPSG:3413", {{-5'000, 0, -6'000}, {7'000, 9, 8'000}}, 1, ""}},
    }));
    DYNAMIC_SECTION(c.name) {
        CHECK_THROWS_WITH(to_item(c.what), contains("crosses the antimeridian or holds a pole"));
    }
    CHECK(to_item({"EPSG:32601", {{170'000, 0, -10'000}, {180'000, 9, -1'000}}, 1, ""})["bbox"][0] <
          -179);
}
