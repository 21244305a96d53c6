#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "tests/voxelserver/tools/survey/survey_fixture.hpp"
#include "voxelserver/tools/survey/scanner.hpp"
#include "voxelserver/tools/survey/truth.hpp"

using namespace terravox::survey;

namespace {

/// Shoots every pulse over an extent and calls visit(pulse, returns).
template <class Visit>
void scan(const SquareModel& model, double density, const Visit& visit) {
    const Scanner scanner(model);
    ScanPattern(model.seed(), density).visit(model.extent().box(), [&](const Pulse& pulse) {
        if (model.extent().box().contains(pulse.foot))
            visit(pulse, scanner.shoot(pulse));
    });
}

/// The village east of the lake with the hotels.
const SquareModel& village() {
    static const SquareModel model(7, {462600, 101380, 256}, 2);
    return model;
}

bool solid_above(const Building& b, Vec2 p) {
    return b.top_m(p).has_value();
}

}  // namespace

TEST_CASE("pulses are as dense as requested, on average", "[survey][scan]") {
    struct Case {
        double density;
        double half_depth;
        double within;
    };
    const auto c = GENERATE(values<Case>({{0.5, 1000, 0.05}, {8, 40, 0.2}}));
    const Box2 area{-1410, -c.half_depth, 1410, c.half_depth};  // six strip distances wide
    std::size_t count = 0;
    ScanPattern(7, c.density).visit(area, [&](const Pulse& pulse) {
        count += area.contains(pulse.foot);
    });
    CHECK(static_cast<double>(count) / (2820.0 * 2 * c.half_depth) ==
          Approx(c.density).epsilon(c.within));
}

TEST_CASE("water is mostly void", "[survey][scan]") {
    const SquareModel model(7, {462320, 101460, 192},
                            1);  // open lake, west of the nadir of the nearest strip
    std::size_t pulses = 0;
    std::size_t echoes = 0;
    scan(model, 1.0, [&](const Pulse& pulse, const Returns& returns) {
        const auto water = model.water_m(pulse.foot);
        if (!water || *water - model.ground_m(pulse.foot) < 1.0)
            return;
        ++pulses;
        for (int i = 0; i < returns.count; ++i)
            echoes +=
                returns.points[static_cast<std::size_t>(i)].classification == las_class::kWater;
    });
    REQUIRE(pulses > 5000);
    CHECK(static_cast<double>(echoes) / static_cast<double>(pulses) < 0.2);
    CHECK(echoes > 0);
}

TEST_CASE("building points lie between ground and ridge, bridge points on the deck above the water",
          "[survey][scan]") {
    const SquareModel model(7, {462600, 101240, 192},
                            1);  // the bridge over the river and the south of the village
    int roofs = 0;
    int decks = 0;
    int wrong = 0;
    scan(model, 4.0, [&](const Pulse&, const Returns& returns) {
        for (int i = 0; i < returns.count; ++i) {
            const auto& point = returns.points[static_cast<std::size_t>(i)];
            if (point.classification == las_class::kBuilding) {
                ++roofs;
                const bool held = std::any_of(
                    model.buildings().begin(), model.buildings().end(), [&](const Building& b) {
                        const Vec2 from = point.at - b.centre;
                        return std::abs(dot(from, b.direction)) < b.half_length_m + 0.2 &&
                               std::abs(dot(from, turn_left(b.direction))) < b.half_width_m + 0.2 &&
                               point.height_m > b.ground_m - 3.2 &&
                               point.height_m < b.top_of_all_m() + 0.2;
                    });
                wrong += !held;
            }
            if (point.classification == las_class::kBridge) {
                ++decks;
                const bool held = std::any_of(
                    model.roads().bridges.begin(), model.roads().bridges.end(),
                    [&](const Bridge& b) {
                        return length(point.at - b.centre) < b.half_length_m + b.half_width_m &&
                               point.height_m > b.deck_m - 0.2 &&
                               point.height_m < b.deck_m + kParapet_m + 0.2 &&
                               point.height_m > b.water_m + 1.0;
                    });
                wrong += !held;
            }
        }
    });
    CHECK(roofs > 1000);
    CHECK(decks > 300);
    CHECK(wrong == 0);
}

TEST_CASE(
    "some houses have balconies and carports, the hotels passages and canopies, all higher than a "
    "storey",
    "[survey][overhang]") {
    std::array<int, 10> found{};
    for (const Building& b : village().buildings()) {
        if (!b.open_beneath() || !village().extent().box().contains(b.centre))
            continue;
        CAPTURE(to_name(b.use), b.centre.x, b.centre.y);
        ++found[static_cast<std::size_t>(b.use)];
        CHECK(b.underside_m < b.eaves_m);
        if (b.use != BuildingUse::kHotel)
            CHECK(b.underside_m - village().ground_m(b.centre) > 3.0);
        CHECK_FALSE(village().water_m(b.centre).has_value());
    }
    for (const BuildingUse use : {BuildingUse::kBalcony, BuildingUse::kCarport,
                                  BuildingUse::kCanopy, BuildingUse::kPassage}) {
        CAPTURE(to_name(use));
        CHECK(found[static_cast<std::size_t>(use)] > 0);
    }
}

TEST_CASE("pulses that lean pass under a slab to the ground, and the others end on it",
          "[survey][overhang]") {
    const Scanner scanner(village());
    std::vector<const Building*> carports;
    for (const Building& b : village().buildings())
        if (b.use == BuildingUse::kCarport)
            carports.push_back(&b);
    REQUIRE(carports.size() > 3);
    int beneath = 0;
    int above = 0;
    int inside = 0;
    ScanPattern(7, 8.0).visit(village().extent().box(), [&](const Pulse& pulse) {
        const Returns returns = scanner.shoot(pulse);
        for (int i = 0; i < returns.count; ++i) {
            const ScanPoint& point = returns.points[static_cast<std::size_t>(i)];
            for (const Building* b : carports) {
                if (!solid_above(*b, point.at))
                    continue;
                beneath += point.classification == las_class::kGround;
                above += point.classification == las_class::kBuilding;
                inside += point.classification == las_class::kBuilding &&
                          point.height_m < b->underside_m - 0.15;
            }
        }
    });
    CHECK(beneath > 20);
    CHECK(above > 500);
    CHECK(inside == 0);
}

TEST_CASE("the truth names the slabs and where it is open beneath them", "[survey][overhang]") {
    const auto json = nlohmann::json::parse(truth_json(village()));
    CHECK(json.at("version") == kTruthVersion);
    int slabs = 0;
    for (const auto& building : json.at("buildings"))
        slabs += building.contains("underside_m");
    const Box2 box = village().extent().box();
    const auto listed = [&](const Building& b) {
        return b.open_beneath() && b.bounds().overlaps(box);
    };
    CHECK(slabs ==
          std::count_if(village().buildings().begin(), village().buildings().end(), listed));

    int open = 0;
    int wrong = 0;
    const auto columns = true_columns(village());
    for (std::size_t i = 0; i < columns.size(); ++i) {
        const TrueColumn& column = columns[i];
        const Vec2 p{box.x0 + static_cast<double>(i % 256) + 0.5,
                     box.y1 - static_cast<double>(i / 256) - 0.5};
        bool slab = false;
        bool solid = false;
        for (const Building& b : village().buildings())
            if (b.top_m(p))
                (b.open_beneath() ? slab : solid) = true;
        wrong += column.open_building != (slab && !solid);
        wrong += column.open_building && column.underside_m - column.ground_m < 2.0F;
        open += column.open_building;
    }
    CHECK(open > 200);
    CHECK(wrong == 0);
}

TEST_CASE("the kind of a column is that of the highest thing above it", "[survey][truth]") {
    const auto columns = true_columns(village());
    REQUIRE(columns.size() == 256U * 256U);
    std::array<int, kTrueKindCount> count{};
    int wrong = 0;
    for (const TrueColumn& column : columns) {
        ++count[static_cast<std::size_t>(column.kind)];
        const bool roof = column.kind >= TrueKind::kRoofRed && column.kind <= TrueKind::kRoofCopper;
        if (roof)
            wrong += column.roof_m < column.crown_m || column.roof_m < column.ground_m;
        if (column.kind == TrueKind::kTree)
            wrong += column.crown_m < column.roof_m || column.crown_m < column.ground_m;
        if (column.kind == TrueKind::kWater)
            wrong += column.water_m < column.ground_m || column.building != TrueColumn::kNone;
    }
    CHECK(wrong == 0);
    for (const TrueKind kind :
         {TrueKind::kGrass, TrueKind::kRoad, TrueKind::kWater, TrueKind::kTree, TrueKind::kRoofRed,
          TrueKind::kRoofGrey, TrueKind::kRoofPale}) {
        CAPTURE(to_name(kind));
        CHECK(count[static_cast<std::size_t>(kind)] > 50);
    }
}
