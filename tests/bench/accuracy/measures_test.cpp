// Tests of the measures: with voxels made from the truth itself, and with the same and one fault at
// a time.
#include "tests/bench/accuracy/measures.hpp"

#include <algorithm>
#include <cmath>

#include "tests/catch.hpp"

using namespace terravox;
using namespace terravox::bench;
using survey::TrueColumn;
using survey::TrueKind;
using voxel::Material;

namespace {

/// The middle of the place: lake, river, brook, bridges, hotels with passages, houses, trees.
const TruthPlace& place() {
    static const TruthPlace truth = [] {
        survey::SurveyOptions options;
        options.square_m = 416;
        options.origin_east_m = 462480;
        options.origin_north_m = 101216;
        return TruthPlace(options, 2);
    }();
    return truth;
}

/// The faults of the voxels.
struct Faults {
    int raised_buildings = 0;        ///< voxels of air below every building
    bool closed_slabs = false;       ///< walls down to the ground under balconies and passages
    bool filled_bridges = false;     ///< decks as dams
    bool swollen_buildings = false;  ///< every building also on the columns around it
    bool trunks = true;
    int waves = 0;  ///< water that is higher by this in every second column of voxels
    Material roofs = Material::kRoof;
};

int to_floor(float metres) {
    return static_cast<int>(std::floor(metres));
}

void push(std::vector<FoundRun>& runs, int y0, int y1, Material material) {
    if (!runs.empty())
        y0 = std::max(y0, static_cast<int>(runs.back().y1));
    if (y0 < y1)
        runs.push_back({static_cast<std::int16_t>(y0), static_cast<std::int16_t>(y1), material});
}

Material to_roof(TrueKind kind, const Faults& faults) {
    if (faults.roofs != Material::kRoof)
        return faults.roofs;
    return kind == TrueKind::kRoofRed    ? Material::kOrangeRoof
           : kind == TrueKind::kRoofGrey ? Material::kGreyRoof
           : kind == TrueKind::kRoofPale ? Material::kFlatRoof
                                         : Material::kRoof;
}

std::vector<FoundRun> find_column(const TrueColumn& c, bool east_of_wave, const Faults& faults) {
    std::vector<FoundRun> runs;
    // Some water is seen wherever there is any, however shallow.
    const int ground = c.water_m > survey::kNoWater
                           ? std::min(to_floor(c.ground_m), to_floor(c.water_m) - 1)
                           : to_floor(c.ground_m);
    push(runs, 300, ground + 1, Material::kGround);
    if (c.water_m > survey::kNoWater)
        push(runs, ground + 1, to_floor(c.water_m) + 1 + (east_of_wave ? faults.waves : 0),
             Material::kWater);
    if (c.building != TrueColumn::kNone) {
        const int bottom = c.open_building && !faults.closed_slabs
                               ? to_floor(c.underside_m)
                               : ground + 1 + faults.raised_buildings;
        push(runs, bottom, to_floor(c.roof_m), Material::kWall);
        push(runs, to_floor(c.roof_m), to_floor(c.roof_m) + 1, to_roof(c.kind, faults));
    }
    if (c.deck_m > survey::kNoWater)
        push(runs, faults.filled_bridges ? 0 : to_floor(c.deck_m) - 1, to_floor(c.deck_m) + 1,
             Material::kBridge);
    if (c.crown_m > survey::kNoWater)
        push(runs, faults.trunks ? 0 : std::max(ground + 3, to_floor(c.crown_m) - 2),
             to_floor(c.crown_m) + 1, Material::kHighVegetation);
    if (c.kind == TrueKind::kWire)
        push(runs, ground + 12, ground + 13, Material::kWire);
    if (c.kind == TrueKind::kPylon)
        push(runs, ground + 1, ground + 24, Material::kTower);
    return runs;
}

VoxelField voxels(const Faults& faults) {
    const Area& area = place().area;
    std::vector<std::vector<FoundRun>> runs(area.size());
    std::vector<float> ground(area.size());
    for (std::size_t i = 0; i < area.size(); ++i) {
        TrueColumn column = place().columns[i];
        if (faults.swollen_buildings && column.building == TrueColumn::kNone)
            for (const std::size_t n : {i + 1, i + static_cast<std::size_t>(area.width)})
                if (n < area.size() && place().columns[n].building != TrueColumn::kNone) {
                    column.building = place().columns[n].building;
                    column.roof_m = place().columns[n].roof_m;
                }
        runs[i] = find_column(column, i % 2 == 1, faults);
        ground[i] = column.ground_m;
    }
    VoxelField out(area, runs, ground);
    out.set_trees(place().trees());
    return out;
}

double value(const Readings& readings, const std::string& metric) {
    const auto& list = readings.list();
    const auto at = std::find_if(list.begin(), list.end(),
                                 [&](const Reading& r) { return r.metric == metric; });
    INFO(metric);
    REQUIRE(at != list.end());
    return at->value;
}

template <class Measure>
Readings measured(const Measure& measure, const Faults& faults) {
    Readings out;
    measure(place(), voxels(faults), out);
    return out;
}

}  // namespace

TEST_CASE("the truth as voxels has no error but rounding", "[bench][accuracy]") {
    const VoxelField found = voxels({});
    Readings r;
    measure_ground(place(), found, r);
    measure_buildings(place(), found, r);
    measure_overhangs(place(), found, r);
    measure_bridges(place(), found, r);
    measure_waters(place(), found, r);
    measure_trees(place(), found, r);
    CHECK(value(r, "ground RMSE, open") == 0);
    CHECK(value(r, "ground RMSE, under buildings") == 0);
    CHECK(value(r, "building footprint IoU") == 1);
    CHECK(value(r, "roof height RMSE") < 0.35);
    CHECK(value(r, "wall base within 1 voxel of the ground") == 1);
    CHECK(value(r, "overhang: columns open beneath the slab") > 0.9);
    CHECK(value(r, "closed buildings: columns with air beneath") == 0);
    CHECK(value(r, "bridge deck IoU") == 1);
    CHECK(value(r, "bridge: columns open beneath") > 0.95);
    CHECK(value(r, "lakes: worst level error beyond its voxel") == 0);
    CHECK(value(r, "lakes: highest less lowest voxel") == 0);
    CHECK(value(r, "river: uphill steps") == 0);
    CHECK(value(r, "brook: uphill steps") == 0);
    CHECK(value(r, "brook: level RMSE beyond its voxel") < 0.03);
    CHECK(value(r, "trees: crowns that float") == 0);
    CHECK(value(r, "trees: F1") == 1);
    CHECK(value(r, "trees: height RMSE") == 0);
}

TEST_CASE("walls that hang or stop in the air are seen", "[bench][accuracy]") {
    const int raised = GENERATE(1, 3);
    CAPTURE(raised);
    Faults faults;
    faults.raised_buildings = raised;
    const Readings r = measured(measure_buildings, faults);
    CHECK(value(r, "wall base within 1 voxel of the ground") < 0.1);
    CHECK(value(r, "wall base without a gap") < 0.1);
    CHECK(value(measured(measure_overhangs, faults), "closed buildings: columns with air beneath") >
          0.9);
}

TEST_CASE("closed passages, bridges as dams and swollen buildings are seen", "[bench][accuracy]") {
    Faults faults;
    faults.closed_slabs = faults.filled_bridges = faults.swollen_buildings = true;
    CHECK(value(measured(measure_overhangs, faults), "overhang: columns open beneath the slab") ==
          0);
    CHECK(value(measured(measure_bridges, faults), "bridge: columns open beneath") == 0);
    CHECK(value(measured(measure_buildings, faults), "building footprint IoU") < 0.9);
}

TEST_CASE("waves on lakes and rivers are seen", "[bench][accuracy]") {
    Faults faults;
    faults.waves = 2;
    const Readings r = measured(measure_waters, faults);
    CHECK(value(r, "lakes: highest less lowest voxel") == 2);
    CHECK(value(r, "lakes: worst level error beyond its voxel") > 1);
    CHECK(value(r, "river: uphill steps") > 50);
}

TEST_CASE("crowns without a trunk are seen", "[bench][accuracy]") {
    Faults faults;
    faults.trunks = false;
    CHECK(value(measured(measure_trees, faults), "trees: crowns that float") > 0.5);
}

TEST_CASE("roofs of the wrong material are seen, and the table says what they are",
          "[bench][accuracy]") {
    const Readings good = measured(measure_materials, {});
    CHECK(value(good, "surface: wrong material, red roof") == 0);
    CHECK(value(good, "surface: wrong material, water") == 0);
    CHECK(value(good, "surface: wrong material, tree") < 0.01);  // bushes lower than a voxel
    Faults faults;
    faults.roofs = Material::kWater;
    const Readings bad = measured(measure_materials, faults);
    CHECK(value(bad, "surface: wrong material, red roof") == 1);
    CHECK(value(bad, "surface: wrong group of materials") >
          value(good, "surface: wrong group of materials"));
    REQUIRE(bad.notes().size() == 1);
    CHECK_THAT(bad.notes()[0], terravox::test::contains("| red roof | "));
    CHECK_THAT(bad.notes()[0], terravox::test::contains("| water 100 % |"));
}

TEST_CASE("leaves at facades and trunks under crowns are counted without a truth",
          "[bench][accuracy]") {
    // A house of one column between a column of leaves, a free one, and two that hold nothing.
    using Runs = std::vector<FoundRun>;
    const Runs house{{0, 1, Material::kGround}, {1, 4, Material::kWall}, {4, 5, Material::kRoof}};
    const Runs tree{
        {0, 1, Material::kGround}, {1, 3, Material::kTrunk}, {3, 9, Material::kHighVegetation}};
    const Runs free{{0, 1, Material::kGround}};
    const VoxelField found({0, 0, 3, 2}, {tree, house, free, {}, {}, {}},
                           std::vector<float>(6, 1.0F));
    Readings r;
    measure_facades(found, r);
    measure_crowns(found, r);
    CHECK(value(r, "facades: faces in leaves") == 2.0 / 6);
    CHECK(value(r, "trunk voxels per column with a crown") == 2);
}
