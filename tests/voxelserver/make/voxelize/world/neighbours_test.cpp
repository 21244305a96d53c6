// What neighbouring patches find in the columns that both know is the same: boxes meet without
// seams.
#include <bit>
#include <map>

#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/steps/made_land.hpp"
#include "tests/voxelserver/make/voxelize/world/cloud.hpp"
#include "voxelserver/make/voxelize/world/land.hpp"
#include "voxelserver/make/voxelize/world/step.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;

namespace {

constexpr int kSide_m = 240;

/// One column of a land of all kinds: a winding river with bridges that no class names, and beside
/// it hills with gaps, houses, canopies, woods and decks at random, in cells that lie across
/// patches.
void add_column(Cloud& cloud, int e, int n, bool coloured) {
    constexpr std::array<std::array<std::uint16_t, 3>, 4> kColours{{{0x7000, 0x8900, 0x4a00},
                                                                    {0x7400, 0x7400, 0x7800},
                                                                    {0xb200, 0x5400, 0x3800},
                                                                    {0x7600, 0x7a00, 0x7e00}}};
    const auto chance = [&](std::uint32_t seed) { return dice(e, n, seed); };
    const auto in_cell = [&](std::uint32_t seed) { return dice(e / 9, n / 7, seed); };
    const auto colour = coloured ? kColours[static_cast<std::size_t>(chance(2) * 3.99)]
                                 : std::array<std::uint16_t, 3>{};
    const auto put = [&](double height, int code) {
        cloud.add(e + 0.1 + 0.8 * dice(e, n, 50), n + 0.1 + 0.8 * dice(e, n, 51), height, code,
                  colour);
    };
    const double off_river = std::abs(e - 115 - 20 * std::sin(n / 31.0)) - 9;
    const double ground =
        105 + (off_river > 20 ? 3 * std::sin(e / 19.0) * std::cos(n / 13.0) : 0) + 0.05 * chance(3);
    if (off_river < 0 && n % 31 >= 7) {
        if (chance(1) < 0.3)
            put(100, kWater);
        return;
    }
    const int kind = off_river < 20 ? 0 : static_cast<int>(dice(e / 20, n / 17, 4) * 5);
    const bool seen_below = chance(5) < 0.5;
    if (kind == 1 && in_cell(6) < 0.7 && chance(7) < 0.8) {
        for (int i = 0; i < 3; ++i)
            put(ground + 6 + 6 * in_cell(8), kBuilding);
        if (in_cell(12) < 0.4)
            put(ground, kGroundClass);  // a canopy
        if (chance(14) < 0.3)
            put(ground + 14 * chance(15), kUnsorted);  // on the roof
    } else if (kind == 2)
        put(ground + 9 + 6 * std::sin(e / 1.5) * std::sin(n / 2.0),
            dice(e / 20, n / 17, 13) < 0.3 ? kUnsorted : kTree);
    else if (kind == 3)
        put(115.5 + std::floor(3 * dice(e / 2, n / 2, 9)), kTree);
    else if (kind == 4 && chance(10) < 0.6)
        put(ground + 9 + 4 * chance(11), kBridge);
    if (off_river < 20 || (kind != 3 && seen_below))
        put(ground, kGroundClass);
}

std::string bits(float value) {
    return " " + std::to_string(std::bit_cast<std::uint32_t>(value));
}

/// What a part says of a column, exactly; "": nothing.
struct Named {
    const char* name;
    int margin;
    std::string (*text)(const Land& land, int x, int z);
};
const std::vector<Named> kParts = {
    {"water", WaterColumns::kMargin,
     [](const Land& land, int x, int z) {
         return land.water->is_water(x, z) ? bits(land.water->level.at(x, z)) : "";
     }},
    {"bed", 2,
     [](const Land& land, int x, int z) {
         return land.water->is_water(x, z) ? bits(land.water->depth_m.at(x, z)) : "";
     }},
    {"decks that no class names", FoundDecks::kMargin,
     [](const Land& land, int x, int z) -> std::string {
         if (!land.decks->found)
             return "";
         const FoundDeck& found = land.decks->found->at(x, z);
         return std::isnan(found.below) ? ""
                                        : bits(found.below) + bits(found.deck.height) +
                                              (found.over_water ? " over water" : "");
     }},
    {"decks", 2,
     [](const Land& land, int x, int z) {
         const Surface& deck = land.decks->over.at(x, z);
         return deck.seen() ? bits(deck.height) + " " + std::to_string(deck.source_class) : "";
     }},
    {"ground", GroundHeights::kMargin,
     [](const Land& land, int x, int z) { return bits(land.ground->at(x, z)); }},
    {"roofs", 2,
     [](const Land& land, int x, int z) {
         const Roof& roof = land.roofs->at(x, z);
         return roof.seen() ? bits(roof.top.height) + std::to_string(roof.appearance_dx) + " " +
                                  std::to_string(roof.appearance_dz)
                            : "";
     }},
    {"what is open beneath", 2,
     [](const Land& land, int x, int z) {
         const Roof& roof = land.roofs->at(x, z);
         return roof.open_beneath() ? bits(roof.bottom) : "";
     }},
    {"crowns", 2,
     [](const Land& land, int x, int z) {
         const Crown& crown = land.crowns->at(x, z);
         return crown.seen() ? bits(crown.height) + " " + std::to_string(crown.top) + " " +
                                   std::to_string(crown.bottom) + " " +
                                   std::to_string(crown.top_voxel.source_class)
                             : "";
     }},
    {"trunks", 2,
     [](const Land& land, int x, int z) {
         return std::string(land.crowns->at(x, z).trunk ? "trunk" : "");
     }},
    {"materials", 2,
     [](const Land& land, int x, int z) {
         return std::string(voxel::material_name(land.surface->material.at(x, z)));
     }},
    {"buildings", 2,
     [](const Land& land, int x, int z) {
         const HouseNumber* house = land.numbers->house(x, z);
         return house == nullptr
                    ? ""
                    : std::to_string(house->own) + " " + std::to_string(house->district) +
                          (house->typical ? " typical" : "");
     }},
    {"trees", 2,
     [](const Land& land, int x, int z) {
         const std::uint64_t number = land.numbers->tree.at(x, z);
         return number == PlaceNumbers::kNone ? "" : std::to_string(number);
     }},
    {"columns", 1,
     [](const Land& land, int x, int z) {
         std::string out;
         for (const Run& run : land.runs->column(x, z))
             out += std::to_string(run.y0) + " to " + std::to_string(run.y1) + ", ";
         return out;
     }},
};

}  // namespace

TEST_CASE("neighbouring patches find the same in the columns that both know",
          "[voxelserver][voxelize][seamless]") {
    const bool coloured = GENERATE(false, true);
    INFO((coloured ? "with" : "without") << " colours");
    const TemporaryFolder folder;
    Cloud cloud;
    for (int n = 0; n < kSide_m; ++n)
        for (int e = 0; e < kSide_m; ++e)
            add_column(cloud, e, n, coloured);
    cloud.write(folder.path() / "land.laz", kCrs, 7);
    Settings settings;
    settings.tints = coloured ? "default" : "north";
    util::StageTimes times;
    PointSet points(OpenWorld::with(folder.path()), settings, times);
    StepContext context(points, nullptr, settings, std::size_t{64} << 20, times);
    const auto make_land = [&](grid::PatchKey key) {
        Land out(context, key);
        run_steps(out, part::kRuns, times);
        return out;
    };
    const grid::PatchKey here{voxel_x(80) >> 6, voxel_z(90) >> 6};
    const Land land = make_land(here);
    REQUIRE(land.decks->found);
    std::map<std::string, int> known;
    for (const auto& [dx, dz] : {std::pair{1, 0}, {0, -1}, {1, -1}, {-1, 0}, {0, 1}, {1, 1}}) {
        const Land other = make_land({here.px + dx, here.pz + dz});
        for (const Named& part : kParts) {
            const auto has = [&](int at) {
                return at >= -part.margin && at < grid::kPatchSize + part.margin;
            };
            for (int z = -part.margin; has(z); ++z)
                for (int x = -part.margin; has(x); ++x) {
                    if (!has(x - 64 * dx) || !has(z - 64 * dz))
                        continue;
                    INFO(part.name << " of column " << x << ", " << z << " and the patch at " << dx
                                   << ", " << dz);
                    const std::string found = part.text(land, x, z);
                    REQUIRE(found == part.text(other, x - 64 * dx, z - 64 * dz));
                    known[part.name] += found.empty() ? 0 : 1;
                }
        }
    }
    for (const Named& part : kParts) {
        INFO(part.name);
        CHECK(known[part.name] > 3);
    }
}
