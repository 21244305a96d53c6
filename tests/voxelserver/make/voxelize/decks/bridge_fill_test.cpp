// Bridge decks.
#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/steps/made_land.hpp"
#include "voxelserver/make/voxelize/decks/bridges.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;

namespace {

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
