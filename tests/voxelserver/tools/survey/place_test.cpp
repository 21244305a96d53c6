#include "survey_fixture.hpp"
#include "voxelserver/tools/survey/square_model.hpp"

using namespace terravox::survey;

namespace {

SquareExtent middle_of_the_place() {
    return {462240, 101232, 512};
}

}  // namespace

TEST_CASE("neighbouring squares agree on everything near their edge", "[survey][model]") {
    const SquareExtent west{462512, 101300, 128};
    const SquareExtent east{462640, 101300, 128};
    const SquareModel a(7, west, 1), b(7, east, 1);
    const double edge = east.box().x0;
    const double south = east.box().y0;
    int differences = 0;
    for (double dx = -30; dx <= 30; dx += 1.7)
        for (double dy = 0; dy < 128; dy += 2.3) {
            const Vec2 p{edge + dx, south + dy};
            differences += a.ground_m(p) != b.ground_m(p);
            differences += a.water_m(p) != b.water_m(p);
            differences += a.cover(p) != b.cover(p);
            differences += a.road_edge_m(p) != b.road_edge_m(p);
        }
    CHECK(differences == 0);

    const Box2 shared{edge - 30, south, edge + 30, south + 128};
    const auto trees_in = [&](const SquareModel& model) {
        std::vector<std::pair<double, double>> out;
        for (const Tree& tree : model.trees())
            if (shared.contains(tree.at))
                out.emplace_back(tree.at.x, tree.height_m);
        std::sort(out.begin(), out.end());
        return out;
    };
    const auto buildings_in = [&](const SquareModel& model) {
        std::vector<std::pair<double, double>> out;
        for (const Building& building : model.buildings())
            if (building.bounds().overlaps(shared))
                out.emplace_back(building.centre.x, building.ridge_m);
        std::sort(out.begin(), out.end());
        return out;
    };
    CHECK_FALSE(trees_in(a).empty());
    CHECK_FALSE(buildings_in(a).empty());
    CHECK(trees_in(a) == trees_in(b));
    CHECK(buildings_in(a) == buildings_in(b));
}

TEST_CASE("the place has what its description promises, for any seed", "[survey][model]") {
    const std::uint64_t seed =
        GENERATE(std::uint64_t{7}, std::uint64_t{1}, std::uint64_t{20260621});
    CAPTURE(seed);
    const SquareModel model(seed, middle_of_the_place(), 2);
    const Site* place = nullptr;
    for (const Site& site : model.terrain().sites())
        if (site.is_the_place())
            place = &site;
    REQUIRE(place != nullptr);
    REQUIRE((place->lake && place->island && place->castle && place->brook));

    CHECK(model.water_m(place->lake->centre + Vec2{30, -30}) == kLakeLevel_m);
    CHECK_FALSE(model.water_m(place->island->centre).has_value());
    CHECK(model.ground_m(place->island->centre) > kLakeLevel_m + 5);
    CHECK(model.ground_m(place->castle->centre) > kLakeLevel_m + 60);

    int houses = 0;
    int castle = 0;
    int church = 0;
    for (const Building& building : model.buildings()) {
        houses += building.use == BuildingUse::kHouse;
        castle += building.use == BuildingUse::kCastle;
        church += building.use == BuildingUse::kChurch;
        CHECK(building.eaves_m > building.ground_m + 1.5);
        CHECK(building.ridge_m >= building.eaves_m);
        CHECK_FALSE(
            (building.use == BuildingUse::kHouse && model.water_m(building.centre).has_value()));
    }
    CHECK(houses > 30);
    CHECK(castle > 12);
    CHECK(church >= 5);

    const auto& bridges = model.roads().bridges;
    CHECK(std::any_of(bridges.begin(), bridges.end(), [](const Bridge& b) {
        return b.deck_m > b.water_m + 4.0 && b.half_width_m > 3.0;
    }));
}

TEST_CASE("water falls along the river and houses do not overlap", "[survey][model]") {
    const River river(7, 0);
    for (double x = -50000; x < 50000; x += 100)
        CHECK(river.level_m(x + 100) < river.level_m(x));

    const SquareModel model(7, {462640, 101300, 256}, 1);
    int overlaps = 0;
    const auto& all = model.buildings();
    for (std::size_t i = 0; i < all.size(); ++i)
        for (std::size_t k = i + 1; k < all.size(); ++k) {
            const bool separate =
                all[i].use == BuildingUse::kFarm && all[k].use == BuildingUse::kFarm;
            if (separate && footprints_overlap(all[i], all[k], 0))
                ++overlaps;
        }
    CHECK(overlaps == 0);
}
