#include "voxelserver/serve/server/open_for_serving.hpp"

#include <cmath>
#include <optional>
#include <utility>

#include "common/geo/crs.hpp"
#include "tests/catch.hpp"

using namespace terravox;
using store::StoredBounds;
using store::StoredSquare;
using store::StoredState;

namespace {

/// Slovenia, where a voxel is half a metre.
voxel::WorldInfo slovenia() {
    const auto crs = geo::Crs::from_text("EPSG:3794");
    voxel::WorldInfo out;
    out.crs = crs.name();
    out.crs_wkt = crs.wkt();
    out.voxel_m = 0.5;
    out.crs_units_per_voxel = 0.5;
    return out;
}

StoredSquare wanted(const std::string& name, const std::string& crs) {
    StoredSquare out;
    out.name = name;
    out.source = "si-lss";
    out.bounds_crs = crs;
    return out;
}

std::vector<http::SquareEntry> placed(const StoredSquare& square,
                                      const voxel::WorldInfo& world = slovenia()) {
    std::optional<store::GrabberStore> store(std::in_place);
    store->squares = {square};
    serve::SquareList list(store);
    const auto first = list.entries({}, world);
    CHECK(list.entries({}, world).size() == first.size());
    return first;
}

}  // namespace

TEST_CASE(
    "a square that is not fetched lies where its catalogue says, in the world's CRS or another",
    "[voxelserver][serve]") {
    const auto crs = geo::Crs::from_text("EPSG:3794");
    const std::array<double, 4> extent{462'000, 101'000, 463'000, 102'000};
    const auto other = GENERATE("", "EPSG:3794", "EPSG:3857", "EPSG:32633", "EPSG:4326");
    INFO(other);
    StoredSquare square = wanted("no_place", other);
    std::array<double, 4> stated = extent;
    const std::string name = other;
    if (!name.empty())
        stated = geo::Transform(crs, geo::Crs::from_text(name)).around(extent);
    square.bounds = StoredBounds{{stated[0], stated[1], 0}, {stated[2], stated[3], 0}};
    const auto found = placed(square);
    REQUIRE(found.size() == 1);
    CHECK(found[0].state == "wanted");
    // A rectangle around a turned one is wider: by some metres in UTM, more where north is turned.
    const int wider = name.empty() || name == "EPSG:3794" ? 0 : 120;
    CHECK(std::abs(found[0].min_x - 924'000) <= wider);
    CHECK(std::abs(found[0].max_x - 926'000) <= wider);
    CHECK(std::abs(found[0].min_z - -204'000) <= wider);
    CHECK(std::abs(found[0].max_z - -202'000) <= wider);
}

TEST_CASE("a square without bounds lies where its name says, in the CRS of its catalogue",
          "[voxelserver][serve]") {
    const auto same = placed(wanted("462_101", "EPSG:3794"));
    REQUIRE(same.size() == 1);
    CHECK(same[0].min_x == 924'000);
    CHECK(same[0].max_z == -202'000);
    // UTM zone 33 is 500 km - 15 degrees east, and from the equator; its squares lie elsewhere.
    const auto utm = placed(wanted("462_5135", "EPSG:32633"));
    REQUIRE(utm.size() == 1);
    CHECK(utm[0].max_z > -400'000);
    CHECK(placed(wanted("a name", "EPSG:3794")).empty());
}

TEST_CASE("a square whose place no world can tell is left out", "[voxelserver][serve]") {
    StoredSquare square = wanted("far", "EPSG:4326");
    square.bounds = StoredBounds{{0, 500, 0}, {1, 501, 0}};
    CHECK(placed(square).empty());
    square.bounds_crs = "no CRS";
    CHECK(placed(square).empty());
    // In a world that does not know where it lies, numbers are all there is.
    CHECK(placed(square, {}).size() == 1);
}

TEST_CASE("squares that are there, or that no source has, are not listed twice or at all",
          "[voxelserver][serve]") {
    StoredSquare square = wanted("462_101", "");
    for (const auto& [state, count] : {std::pair{StoredState::kWanted, 1u},
                                       {StoredState::kFailed, 1u},
                                       {StoredState::kFetched, 0u},
                                       {StoredState::kMissing, 0u}}) {
        square.state = state;
        CHECK(placed(square).size() == count);
    }
}
