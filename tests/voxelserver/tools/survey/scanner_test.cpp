#include <array>

#include "survey_fixture.hpp"
#include "voxelserver/tools/survey/scanner.hpp"

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

TEST_CASE("pulses do not depend on the requested area", "[survey][scan]") {
    const Box2 whole{0, 0, 60, 60};
    const Box2 part{20, 20, 40, 40};
    std::vector<std::uint64_t> from_whole;
    std::vector<std::uint64_t> from_part;
    const ScanPattern pattern(7, 4.0);
    pattern.visit(whole, [&](const Pulse& pulse) {
        if (part.contains(pulse.foot))
            from_whole.push_back(pulse.key);
    });
    pattern.visit(part, [&](const Pulse& pulse) {
        if (part.contains(pulse.foot))
            from_part.push_back(pulse.key);
    });
    CHECK_FALSE(from_part.empty());
    CHECK(from_part == from_whole);
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

TEST_CASE("returns of a pulse are numbered from the top", "[survey][scan]") {
    const SquareModel model(7, {462300, 101780, 128}, 1);  // forest
    std::array<int, Returns::kMax + 1> by_count{};
    int wrong = 0;
    scan(model, 4.0, [&](const Pulse&, const Returns& returns) {
        ++by_count[static_cast<std::size_t>(returns.count)];
        for (int i = 0; i < returns.count; ++i) {
            const auto& point = returns.points[static_cast<std::size_t>(i)];
            wrong += point.return_number != i + 1 || point.number_of_returns != returns.count;
            wrong +=
                i > 0 && point.height_m > returns.points[static_cast<std::size_t>(i - 1)].height_m;
        }
    });
    CHECK(wrong == 0);
    CHECK(by_count[1] > 1000);
    CHECK(by_count[2] > 1000);
    CHECK(by_count[3] > 1000);
    CHECK(by_count[0] < by_count[1]);
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
