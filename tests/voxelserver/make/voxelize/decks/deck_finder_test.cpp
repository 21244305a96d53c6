// Decks that no class names: which strips of land are recognised, and which are not.
#include <algorithm>
#include <cmath>
#include <functional>

#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/steps/made_land.hpp"
#include "voxelserver/make/voxelize/decks/bridges.hpp"
#include "voxelserver/make/voxelize/decks/deck_section.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;

namespace {

using Returns = MadeLand::Returns;
constexpr double kStreet = 105, kLevel = 100;  // voxels = metres

/// A place that a river, canal or road cuts through from north to south, all lengths in columns.
/// `along` runs from west to east.
struct Place {
    double angle_deg = 0;   ///< of everything, about (32, 32)
    double half_gap = 12;   ///< of the river or lower road
    double bank = 0;        ///< over which the land slopes down to it; 0 = a quay
    double half_width = 4;  ///< of the deck
    double deck = kStreet;
    std::uint8_t deck_class = kGroundClass;
    bool wet = true;               ///< else the lower level is ground
    double from = -1e9, to = 1e9;  ///< the deck exists between those
    double density = 4;            ///< points per column

    void returns(int x, int z, Returns& out) const {
        const double turn = angle_deg * 3.14159265358979 / 180;
        const double c = std::cos(turn);
        const double s = std::sin(turn);
        for (int i = 0; i < static_cast<int>(density); ++i) {
            const double dx = dice(x, z, 11 + static_cast<std::uint32_t>(i));
            const double dz = dice(x, z, 41 + static_cast<std::uint32_t>(i));
            const double px = x + dx - 32;
            const double pz = z + dz - 32;
            const double along = c * px + s * pz;
            const double across = -s * px + c * pz;
            const double noise = 0.08 * (dice(x, z, 71 + static_cast<std::uint32_t>(i)) - 0.5);
            const auto put = [&](double height, std::uint8_t code) {
                out.push_back({height + noise, code, {}, dx, dz});
            };
            const double out_of_gap = std::abs(along) - half_gap;
            if (std::abs(across) < half_width && along > from && along < to && out_of_gap < bank)
                put(deck, deck_class);
            else if (out_of_gap >= bank)
                put(kStreet, kGroundClass);
            else if (out_of_gap >= 0)
                put(kLevel + (kStreet - kLevel) * out_of_gap / bank, kGroundClass);
            else if (!wet)
                put(kLevel, kGroundClass);
            else if (dice(x, z, 97) < 0.3 && i == 0)
                put(kLevel, kWater);
        }
    }
    [[nodiscard]] bool over_gap(int x, int z) const {
        return inside(x, z, half_gap - (bank > 0 ? 4 : 2), half_width - 0.6);
    }
    [[nodiscard]] bool near_deck(int x, int z) const {
        return inside(x, z, half_gap + bank + 2, half_width + 2);
    }

private:
    [[nodiscard]] bool inside(int x, int z, double length, double width) const {
        const double turn = angle_deg * 3.14159265358979 / 180;
        const double c = std::cos(turn);
        const double s = std::sin(turn);
        const double px = x + 0.5 - 32;
        const double pz = z + 0.5 - 32;
        return std::abs(c * px + s * pz) < length && std::abs(-s * px + c * pz) < width;
    }
};

/// Finds decks as the maker of boxes does: water first, from the same land.
class Search {
public:
    explicit Search(MadeLand::ReturnsAt returns, double voxel_m = 1)
        : m_land(std::move(returns)), m_voxel_m(voxel_m) {
        m_land.limit(
            [](std::int32_t x, std::int32_t z) { return std::abs(x) < 250 && std::abs(z) < 250; });
        water::WaterOptions options;
        options.cell_voxels = m_land.cell_voxels();
        options.voxel_m = voxel_m;
        m_bodies = std::make_unique<water::WaterBodies>(m_land, options);
    }
    [[nodiscard]] FoundDecks at(grid::PatchKey patch, const Settings::Bridges& settings = {}) {
        WaterAccess access{m_land, *m_bodies, m_land.cell_voxels()};
        const auto found = find_decks(m_land.window(patch), asprs(), &access, settings, m_voxel_m);
        return found ? *found : FoundDecks{};
    }
    [[nodiscard]] bool any_seeds(grid::PatchKey patch) {
        return find_deck_seeds(m_land.window(patch), DeckLimits({}, m_voxel_m)).has_value();
    }

private:
    MadeLand m_land;
    double m_voxel_m;
    std::unique_ptr<water::WaterBodies> m_bodies;
};

int decks_in(const FoundDecks& found) {
    return static_cast<int>(std::count_if(found.values().begin(), found.values().end(),
                                          [](const FoundDeck& f) { return f.deck.seen(); }));
}

void require_deck(const Place& place, bool over_water) {
    Search search([&](int x, int z, Returns& out) { place.returns(x, z, out); });
    const auto found = search.at({0, 0});
    int inside = 0;
    int missed = 0;
    int outside = 0;
    FoundDecks::each([&](int x, int z) {
        const FoundDeck& f = found.at(x, z);
        if (place.over_gap(x, z)) {
            ++inside;
            missed += f.deck.seen() ? 0 : 1;
        }
        if (!f.deck.seen())
            return;
        outside += place.near_deck(x, z) ? 0 : 1;
        INFO("column " << x << ", " << z);
        CHECK(std::abs(f.deck.height - place.deck) < 0.2);
        CHECK(std::abs(f.below - kLevel) < (place.bank > 0 ? 3.5 : 0.3));
        if (place.over_gap(x, z))
            CHECK(f.over_water == over_water);
    });
    CHECK(inside > 20);
    CHECK(missed <= inside / 50);
    CHECK(outside == 0);
}

using Returns = MadeLand::Returns;

void put(Returns& out, int decks, double deck, int grounds, std::uint8_t below = kGroundClass) {
    for (int i = 0; i < decks; ++i)
        out.push_back({deck, kBridge});
    for (int i = 0; i < grounds; ++i)
        out.push_back({10.5, below});
}

bool on_bridge(int x, int z) {
    return z >= 30 && z < 36 && x >= 10;
}

}  // namespace

TEST_CASE("a deck over water or a lower road is found, however it lies and whatever its class",
          "[voxelserver][voxelize][bridges]") {
    struct Case {
        const char* name;
        Place place;
    };
    const auto c = GENERATE(values<Case>({
        {"over a river", {}},
        {"at 20 degrees", {.angle_deg = 20}},
        {"at 110 degrees", {.angle_deg = 110}},
        {"a footbridge 3 m wide at 30 degrees", {.angle_deg = 30, .half_width = 1.5}},
        {"14 m wide at 45 degrees", {.angle_deg = 45, .half_width = 7}},
        {"over sloping banks", {.half_gap = 8, .bank = 8}},
        {"over a river 70 m wide", {.half_gap = 35}},
        {"unclassified returns at 45 degrees", {.angle_deg = 45, .deck_class = kUnsorted}},
        {"over a road at 45 degrees", {.angle_deg = 45, .wet = false}},
        {"over a road, two points in a column", {.half_width = 5, .wet = false, .density = 2}},
    }));
    DYNAMIC_SECTION(c.name) {
        require_deck(c.place, c.place.wet);
    }
}

TEST_CASE("what is no deck stays land", "[voxelserver][voxelize][bridges]") {
    const auto ground = [](double height) { return Return{height, kGroundClass}; };
    const auto water = [](double height) { return Return{height, kWater}; };
    struct Case {
        const char* name;
        std::function<Return(int x, int z)> at;
    };
    const std::vector<Case> cases = {
        {"a dyke between two lakes",
         [=](int, int z) {
             const double top = kStreet - std::max(0.0, std::abs(z - 32) - 3.0) / 2;
             return top > kLevel ? ground(top) : water(kLevel);
         }},
        {"a road on a bank of earth, slopes 1 : 1.5",
         [=](int, int z) {
             return ground(std::max(kLevel, kStreet - std::max(0, std::abs(z - 32) - 4) / 1.5));
         }},
        {"stairs of terraces",
         [=](int, int z) { return ground(kStreet - 3 * std::floor(z / 8.0)); }},
        {"houses along a canal",
         [=](int, int z) {
             if (z >= 20 && z < 30)
                 return Return{kStreet + 9, kBuilding};
             return z >= 34 && z < 46 ? water(kLevel) : ground(kStreet);
         }},
        {"a weir",
         [=](int x, int z) {
             if (std::abs(x - 32) > 12)
                 return ground(kStreet);
             return z >= 30 && z < 34 ? ground(kLevel + 3.2) : water(z < 32 ? kLevel + 3 : kLevel);
         }},
        {"a long wall",
         [=](int, int z) { return ground(std::abs(z - 32) <= 1 ? kStreet : kLevel); }},
        {"a hedge of unclassified returns",
         [=](int, int z) {
             return std::abs(z - 32) <= 1 ? Return{kLevel + 2.5, kUnsorted} : ground(kLevel);
         }},
        {"a low causeway",
         [=](int, int z) { return std::abs(z - 32) < 4 ? ground(kLevel + 0.9) : water(kLevel); }},
        {"a house on piles in a lake",
         [=](int x, int z) {
             return std::abs(z - 32) < 4 && std::abs(x - 32) < 6 ? Return{kStreet, kBuilding}
                                                                 : water(kLevel);
         }},
    };
    for (const Case& c : cases)
        DYNAMIC_SECTION(c.name) {
            Search search([&](int x, int z, Returns& out) {
                const Return seen = c.at(x, z);
                if (seen.source_class != kWater || dice(x, z, 1) < 0.3)
                    out.push_back(seen);
            });
            CHECK(decks_in(search.at({0, 0})) == 0);
        }
    for (const Place& place : {Place{.half_gap = 30, .half_width = 2, .to = -6},
                               Place{.half_gap = 30, .half_width = 2, .from = -9, .to = 9}})
        DYNAMIC_SECTION((place.from < -100 ? "a pier" : "a raft")) {
            Search search([&](int x, int z, Returns& out) { place.returns(x, z, out); });
            CHECK(decks_in(search.at({0, 0})) == 0);
        }
}

TEST_CASE("a parapet belongs to the deck, and a gap in it is closed",
          "[voxelserver][voxelize][bridges]") {
    const Place place;
    const auto parapet = [](int, int z) { return z == 28 || z == 35; };
    Search search([&](int x, int z, Returns& out) {
        if (x == 30 && z == 31)
            return;
        place.returns(x, z, out);
        if (place.near_deck(x, z) && std::abs(x - 31.5) < 12 && parapet(x, z))
            out.assign(3, {kStreet + 1.1, kGroundClass});
    });
    const auto found = search.at({0, 0});
    for (int x = 23; x < 41; ++x)
        for (int z = 28; z < 36; ++z) {
            INFO("column " << x << ", " << z);
            REQUIRE(found.at(x, z).deck.seen());
            REQUIRE(std::abs(found.at(x, z).deck.height -
                             (parapet(x, z) ? kStreet + 1.1 : kStreet)) < 0.1);
        }
}

TEST_CASE("the search can be switched off and its limits set", "[voxelserver][voxelize][bridges]") {
    const Place place;
    Search search([&](int x, int z, Returns& out) { place.returns(x, z, out); });
    struct Case {
        const char* name;
        Settings::Bridges settings;
        bool found;
    };
    Settings::Bridges off;
    Settings::Bridges narrow;
    Settings::Bridges high;
    off.recognise = false;
    narrow.widest_m = 5;
    high.above_water_m = 8;
    for (const Case& c : {Case{"as it is", {}, true},
                          {"off", off, false},
                          {"narrower decks only", narrow, false},
                          {"higher decks only", high, false}}) {
        INFO(c.name);
        CHECK((decks_in(search.at({0, 0}, c.settings)) > 0) == c.found);
    }
}

TEST_CASE("land without drops on two sides has no seeds, and every deck lies among them",
          "[voxelserver][voxelize][bridges]") {
    Search slope(
        [](int x, int z, Returns& out) { out.push_back({100 + 0.3 * x + 0.2 * z, kGroundClass}); });
    CHECK_FALSE(slope.any_seeds({0, 0}));
    Search quay(
        [](int, int z, Returns& out) { out.push_back({z < 32 ? kStreet : kLevel, kGroundClass}); });
    CHECK_FALSE(quay.any_seeds({0, 0}));
    Search river([](int x, int z, Returns& out) { Place{}.returns(x, z, out); });
    CHECK(river.any_seeds({0, 0}));
}

TEST_CASE("a column belongs to a deck when a good part of its low returns are of the bridge",
          "[voxelserver][voxelize][bridges]") {
    struct Case {
        const char* name;
        int decks;
        int below;
        std::uint8_t what;
        bool deck;
    };
    const auto c = GENERATE(values<Case>({
        {"only deck", 3, 0, kGroundClass, true},
        {"pulses past the railing", 3, 3, kGroundClass, true},
        {"pulses past the railing into water", 3, 3, kWater, true},
        {"hardly any deck", 1, 8, kGroundClass, false},
        {"none", 0, 4, kGroundClass, false},
    }));
    DYNAMIC_SECTION(c.name) {
        // The bridge's southern edge as the case says.
        MadeLand land([&](int x, int z, Returns& out) {
            if (on_bridge(x, z) && z == 35)
                put(out, c.decks, 25, c.below, c.what);
            else
                put(out, on_bridge(x, z) ? 3 : 0, 25, on_bridge(x, z) ? 0 : 3);
        });
        const auto decks = fill_decks(land.window({0, 0}));
        Margined<Surface>::each([&](int x, int z) {
            INFO("column " << x << ", " << z);
            REQUIRE(decks.at(x, z).seen() == (on_bridge(x, z) && (z < 35 || c.deck)));
            if (decks.at(x, z).seen())
                REQUIRE((decks.at(x, z).height == 25 && decks.at(x, z).source_class == kBridge));
        });
    }
}

TEST_CASE("gaps in a deck take the median of the decks around; nothing grows beyond its edge",
          "[voxelserver][voxelize][bridges]") {
    struct Case {
        const char* name;
        int grounds;
    };
    const auto c = GENERATE(values<Case>({{"no return", 0}, {"a return of what is beneath", 2}}));
    DYNAMIC_SECTION(c.name) {
        MadeLand land([&](int x, int z, Returns& out) {
            if (x == 40 && z == 32)
                put(out, 0, 0, c.grounds);
            else
                put(out, on_bridge(x, z) ? 2 : 0, 25 + 0.5 * (x - 40), on_bridge(x, z) ? 0 : 2);
        });
        const auto decks = fill_decks(land.window({0, 0}));
        REQUIRE(decks.at(40, 32).seen());
        CHECK(std::abs(decks.at(40, 32).height - 25) <= 0.5f);
        Margined<Surface>::each(
            [&](int x, int z) { REQUIRE(decks.at(x, z).seen() == on_bridge(x, z)); });
    }
}

TEST_CASE("land without bridges has no decks, and a switched-off step shows the points' own",
          "[voxelserver][voxelize][bridges]") {
    MadeLand plain([](int, int, Returns& out) { put(out, 0, 0, 2); });
    const auto none = fill_decks(plain.window({0, 0}));
    CHECK(std::none_of(none.values().begin(), none.values().end(),
                       [](const Surface& s) { return s.seen(); }));
    MadeLand sparse([](int x, int z, Returns& out) { put(out, x % 2 == 0 ? 1 : 0, 20 + z, 9); });
    const auto seen = seen_decks(sparse.window({0, 0}));
    Margined<Surface>::each([&](int x, int z) {
        REQUIRE(seen.at(x, z).seen() == (x % 2 == 0));
        if (x % 2 == 0)
            REQUIRE(seen.at(x, z).height == static_cast<float>(20 + z));
    });
}
