#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <string>

#include "tests/catch.hpp"
#include "tests/common/voxel/material_grid.hpp"

using namespace terravox::voxel;
using terravox::test::find_top;
using terravox::test::make_level;
using terravox::test::material_at;
using terravox::test::MaterialGrid;
using enum terravox::voxel::Material;

namespace {

template <class Each>
void for_columns(int level, const Each& each) {
    for (int x = 0; x < 64 >> level; ++x)
        for (int z = 0; z < 64 >> level; ++z)
            each(x, z);
}
bool solid(Material m) {
    return m != kAir;
}
bool leaf(Material m) {
    return m == kHighVegetation;
}
bool roof(Material m) {
    return m == kOrangeRoof;
}

template <class Height>
MaterialGrid terrain(const Height& height) {
    MaterialGrid grid;
    for_columns(0, [&](int x, int z) {
        const int top = height(x, z);
        grid.fill({x, x + 1}, {0, top}, {z, z + 1}, kSoil);
        grid.set(x, top - 1, z, kGrass);
    });
    return grid;
}

// How much too high the ground of a level is, in voxels of that level, on average.
double mean_rise(const Box& fine, int level) {
    const auto coarse =
        make_level(std::shared_ptr<const Box>(std::shared_ptr<const Box>(), &fine), level);
    double sum = 0;
    for_columns(0, [&](int x, int z) {
        sum += find_top(*coarse, x >> level, z >> level, solid) -
               find_top(fine, x, z, solid) / double(1 << level);
    });
    return sum / 4096;
}

double covered(const Box& box, int level, bool (*counts)(Material)) {
    double sum = 0;
    for_columns(level, [&](int x, int z) { sum += find_top(box, x, z, counts) > 0; });
    return sum / (4096 >> (2 * level));
}

}  // namespace

TEST_CASE("flat ground rises by at most half a coarse voxel on average over its heights",
          "[common][voxel][levels]") {
    const int level = GENERATE(range(1, 6));
    double sum = 0;
    for (int h = 64; h < 64 + (1 << level); ++h) {
        const double rise = mean_rise(*terrain([&](int, int) { return h; }).build(), level);
        CHECK((rise >= 0 && rise < 1));
        sum += rise;
    }
    INFO("level " << level);
    CHECK(sum / (1 << level) <= 0.5);
}

TEST_CASE("sloping, stepped and rough ground keeps its height on average",
          "[common][voxel][levels]") {
    struct Case {
        const char* name;
        double slope_x;
        double slope_z;
        int step;
        int rough;
    };
    const auto c = GENERATE(values<Case>({
        {"stairs of one", 1, 0, 1, 1},
        {"stairs of one, down to the south-east", -0.5, -0.5, 1, 1},
        {"a steep slope", 1.4, -0.9, 1, 1},
        {"rough ground", 0.3, -0.2, 1, 4},
        {"a cliff's height in a few columns", 2.4, 0, 1, 2},
    }));
    const int level = GENERATE(range(1, 6));
    DYNAMIC_SECTION(c.name << ", level " << level) {
        double sum = 0;
        constexpr int kLifts = 4;  // where between two coarse layers it lies must not matter
        for (int lift = 0; lift < kLifts; ++lift) {
            std::mt19937 random(11);
            const auto grid = terrain([&](int x, int z) {
                const int h = static_cast<int>(std::floor(60 + c.slope_x * x + c.slope_z * z));
                return (lift << level) / kLifts + h / c.step * c.step +
                       static_cast<int>(random() % static_cast<unsigned>(c.rough));
            });
            sum += mean_rise(*grid.build(), level);
        }
        // Square to the surface: a cliff that moves sideways by a quarter of a voxel rises by more.
        CAPTURE(sum / kLifts);
        CHECK(std::abs(sum / kLifts) / std::hypot(1, c.slope_x, c.slope_z) <= 0.5);
    }
}

TEST_CASE("a bridge deck one voxel thick stays, with its way beneath", "[common][voxel][levels]") {
    struct Case {
        const char* name;
        int width;
        bool diagonal;
    };
    const auto c = GENERATE(values<Case>({{"wide", 7, false},
                                          {"three wide", 3, false},
                                          {"one wide", 1, false},
                                          {"one wide and diagonal", 1, true}}));
    const int at = GENERATE(range(0, 4));
    DYNAMIC_SECTION(c.name << " at offset " << at) {
        MaterialGrid grid = terrain([](int, int) { return 20; });
        const int y = 40 + at % 2;
        const int z0 = 20 + at / 2;
        const auto lies_on = [&](int x, int z) {
            return c.diagonal ? z == (x + z0) % 64 : z >= z0 && z < z0 + c.width;
        };
        for_columns(0, [&](int x, int z) {
            if (lies_on(x, z))
                grid.set(x, y, z, kBridge);
        });
        for (int level = 1; level <= 2; ++level) {
            const auto box = make_level(grid.build(), level);
            int lost = 0;
            int blocked = 0;
            for_columns(0, [&](int x, int z) {
                if (!lies_on(x, z))
                    return;
                lost += material_at(*box, x >> level, y >> level, z >> level) != kBridge;
                blocked += material_at(*box, x >> level, (y >> level) - 1, z >> level) != kAir;
            });
            INFO("level " << level);
            CHECK(lost == 0);
            CHECK(blocked == 0);
        }
    }
}

TEST_CASE("a gable roof is still a roof two levels up", "[common][voxel][levels]") {
    const int at = GENERATE(range(0, 8));
    INFO("offset " << at);
    MaterialGrid grid = terrain([](int, int) { return 20; });
    const int x0 = 20 + (at & 1);
    const int z0 = 14 + (at >> 1 & 1);
    const int y0 = 20 + (at >> 2);
    const auto roof_y = [&](int x) { return y0 + 8 + std::min(x - x0, x0 + 18 - x); };
    for (int x = x0; x < x0 + 19; ++x) {  // walls under a roof without a loft
        for (int z = z0; z < z0 + 24; ++z) {
            if (x == x0 || x == x0 + 18 || z == z0 || z == z0 + 23)
                grid.fill({x, x + 1}, {y0, roof_y(x)}, {z, z + 1}, kWall);
            grid.set(x, roof_y(x), z, kOrangeRoof);
        }
    }
    for (int level = 1; level <= 2; ++level) {
        const auto box = make_level(grid.build(), level);
        int lost = 0;
        int low_or_high = 0;
        for (int x = x0; x < x0 + 19; ++x)
            for (int z = z0; z < z0 + 24; ++z) {
                const int top = find_top(*box, x >> level, z >> level, roof);
                lost += top == 0 || top != find_top(*box, x >> level, z >> level, solid);
                low_or_high += std::abs((top << level) - roof_y(x) - 1) > 2 << level;
            }
        INFO("level " << level);
        CHECK(lost == 0);
        CHECK(low_or_high == 0);
    }
}

TEST_CASE("a town keeps its lanes: houses do not go on growing, level by level",
          "[common][voxel][levels]") {
    // Houses of 9 x 6 at all angles, solid as surveys make them; averaged over many towns.
    std::array<double, 5> cover{};
    constexpr int kTowns = 12;
    for (int town = 0; town < kTowns; ++town) {
        std::mt19937 random(static_cast<unsigned>(town));
        MaterialGrid grid = terrain([](int, int) { return 20; });
        for (int i = 0; i < 16; ++i) {
            const double a = static_cast<double>(random() % 314) / 100;
            const double cx = 8 + 16 * (i % 4) + static_cast<double>(random() % 40) / 10;
            const double cz = 8 + 16 * (i / 4) + static_cast<double>(random() % 40) / 10;
            for_columns(0, [&](int x, int z) {
                const double u = (x - cx) * std::cos(a) + (z - cz) * std::sin(a);
                const double v = (z - cz) * std::cos(a) - (x - cx) * std::sin(a);
                if (std::abs(u) <= 4.5 && std::abs(v) <= 3) {
                    grid.fill({x, x + 1}, {20, 27}, {z, z + 1}, kWall);
                    grid.set(x, 27, z, kOrangeRoof);
                }
            });
        }
        const auto fine = grid.build();
        for (int level = 0; level < 5; ++level)
            cover[static_cast<std::size_t>(level)] +=
                covered(*make_level(fine, level), level, roof) / kTowns;
    }
    CAPTURE(cover[0], cover[1], cover[2], cover[3], cover[4]);
    // Where all shells are kept a house gains up to a voxel of width; from level 3 on it keeps its
    // area, and what was gained fades.
    CHECK(cover[1] < 1.5 * cover[0]);
    CHECK(cover[2] < 2.4 * cover[0]);
    CHECK(cover[3] < 1.7 * cover[0]);
    CHECK(cover[4] < 1.7 * cover[0]);
    CHECK(cover[4] > 0.7 * cover[0]);
}

TEST_CASE("a lake stays flat, whole and water, whatever its height and depth",
          "[common][voxel][levels]") {
    const int surface = GENERATE(96, 97, 99, 102, 105, 111);
    const int depth = GENERATE(1, 3, 8);
    INFO("surface " << surface << ", depth " << depth);
    const auto far_in = [](int x, int z) {
        return std::max(std::abs(x - 32), std::abs(z - 32));
    };  // 0 in the middle
    MaterialGrid grid = terrain([&](int x, int z) {
        return far_in(x, z) < 29 ? surface - depth : surface + (far_in(x, z) > 30);
    });
    for_columns(0, [&](int x, int z) {
        if (far_in(x, z) < 29) {
            grid.fill({x, x + 1}, {surface - depth, surface}, {z, z + 1}, kWater);
            grid.set(x, surface - depth - 1, z, kSand);
        }
    });
    for (int level = 1; level <= 4; ++level) {
        const auto box = make_level(grid.build(), level);
        const int expected = (surface + (1 << level) - 1) >> level;
        const int margin = 32 - (24 >> level << level);
        int holes = 0;
        int steps = 0;
        int dry = 0;
        for (int x = margin; x < 64 - margin; ++x)
            for (int z = margin; z < 64 - margin; ++z) {
                const int top = find_top(*box, x >> level, z >> level, solid);
                holes += top < expected;
                steps += top > expected;
                dry += top > 0 && material_at(*box, x >> level, top - 1, z >> level) != kWater;
            }
        INFO("level " << level);
        CHECK(holes == 0);
        CHECK(steps == 0);
        CHECK(dry == 0);
        if (level == 1 && depth == 8)
            CHECK(find_top(*box, 16, 16, [](Material m) { return !see_through(m); }) <=
                  expected - 4);  // one sees down to the bed
    }
}

TEST_CASE("a shore keeps its place on average and has no gap", "[common][voxel][levels]") {
    const auto seed = GENERATE(range(1u, 9u));
    INFO("seed " << seed);
    std::mt19937 random(seed);
    const int surface = 40 + static_cast<int>(seed % 2);
    const double a = static_cast<double>(random() % 628) / 100;
    const double shift = static_cast<double>(random() % 100) / 10;
    const auto wet = [&](int x, int z) {
        return (x - 32) * std::cos(a) + (z - 32) * std::sin(a) < shift + 3 * std::sin(z * 0.3);
    };
    MaterialGrid grid = terrain([&](int x, int z) { return wet(x, z) ? surface - 4 : surface; });
    for_columns(0, [&](int x, int z) {
        if (wet(x, z))
            grid.fill({x, x + 1}, {surface - 4, surface}, {z, z + 1}, kWater);
    });
    const auto fine = grid.build();
    double wet_columns = 0;
    for_columns(0, [&](int x, int z) { wet_columns += wet(x, z) / 4096.0; });
    for (int level = 1; level <= 3; ++level) {
        const auto box = make_level(fine, level);
        const int expected = (surface + (1 << level) - 1) >> level;
        int uneven = 0;
        double water = 0;
        for_columns(level, [&](int x, int z) {
            uneven += find_top(*box, x, z, solid) != expected;
            water += material_at(*box, x, expected - 1, z) == kWater;
        });
        INFO("level " << level);
        CHECK(uneven == 0);
        CHECK(std::abs(water / (4096 >> (2 * level)) - wet_columns) < 0.02 * (1 << level));
    }
}

TEST_CASE("a forest keeps its cover and its gaps", "[common][voxel][levels]") {
    struct Case {
        const char* name;
        int trees;
        double radius;
        int density_percent;
    };
    const auto c = GENERATE(values<Case>({
        {"dense crowns", 40, 5, 45},
        {"thin crowns", 40, 5, 15},
        {"scattered trees", 12, 4, 35},
        {"bushes", 60, 2, 40},
        {"lone leaves", 400, 0.6, 100},
    }));
    const auto seed = GENERATE(1u, 2u);
    DYNAMIC_SECTION(c.name << ", seed " << seed) {
        std::mt19937 random(seed);
        MaterialGrid grid = terrain([](int, int) { return 20; });
        for (int i = 0; i < c.trees; ++i) {
            const int tx = static_cast<int>(random() % 64);
            const int tz = static_cast<int>(random() % 64);
            const int ty = 30 + static_cast<int>(random() % 8);
            for_columns(0, [&](int x, int z) {
                for (int y = 22; y < 50; ++y) {
                    const double d = std::hypot(x - tx, y - ty, z - tz);
                    if (d <= c.radius && random() % 100 < static_cast<unsigned>(c.density_percent))
                        grid.set(x, y, z, kHighVegetation);
                }
            });
        }
        const auto fine = grid.build();
        const double cover = covered(*fine, 0, leaf);
        for (int level = 1; level <= 2; ++level) {
            INFO("level " << level << ", cover of the fine forest " << cover);
            CHECK(covered(*make_level(fine, level), level, leaf) ==
                  Approx(cover).margin(level == 1 ? 0.08 : 0.14));
        }
    }
}

TEST_CASE("one of four lone voxels survives, so that they cover what they covered",
          "[common][voxel][levels]") {
    const auto material = GENERATE(kHighVegetation, kWire, kObject, kUnknown);
    INFO(material_name(material));
    int survivors = 0;
    for (int i = 0; i < 8; ++i) {
        MaterialGrid grid;
        grid.set(20 + i % 2, 30 + i / 4, 40 + i / 2 % 2, material);
        const auto box = make_level(grid.build(), 1);
        if (!box)
            continue;
        ++survivors;
        CHECK(material_at(*box, 10, 15, 20) == material);
    }
    CHECK(survivors == 2);
}

TEST_CASE("wires fade: half their length goes with each level", "[common][voxel][levels]") {
    const int level = GENERATE(1, 2, 3);
    double length = 0;
    for (int i = 0; i < 64; ++i) {  // one wire in each row, each time alone
        MaterialGrid grid;
        grid.fill({0, 64}, {100, 101}, {i, i + 1}, kWire);
        const auto box = make_level(grid.build(), level);
        if (box)
            for_columns(level, [&](int x, int z) {
                length += (1 << level) * (find_top(*box, x, z, solid) > 0);
            });
    }
    INFO("level " << level);
    CHECK(length == 64 * 64 >> level);
}

TEST_CASE("a coarse voxel looks like what is seen of it", "[common][voxel][levels]") {
    // The four children below, then those above them; a blank is air.
    struct Case {
        const char* name;
        std::string children;
        Material expected;
    };
    const std::map<char, Material> materials = {
        {'s', kSoil},  {'g', kGrass},         {'w', kWall},           {'r', kRoof},   {'b', kSand},
        {'~', kWater}, {'l', kLowVegetation}, {'h', kHighVegetation}, {'o', kObject}, {'R', kRock}};
    const auto c = GENERATE_COPY(values<Case>({
        {"grass on soil", "ssssg   ", kSoil},
        {"more grass on soil", "ssssg  g", kGrass},
        {"a roof on walls", "wwwwrrrr", kRoof},
        {"a wall next to the ground", "wgwgw w ", kWall},
        {"a lone wall on little ground", "gg  w   ", kWall},
        {"leaves on the ground", "ggggll  ", kGrass},
        {"leaves over a corner of ground", "g   ll  ", kLowVegetation},
        {"shallow water on its bed", "bbbb~~~~", kWater},
        {"water on three columns", "bbbbb~~~", kWater},
        {"leaves over water", "~~~~hh  ", kWater},
        {"a pier in water", "w~~~w~~~", kWall},
        {"a buoy next to the key column", "~~~~ o  ", kWater},
        {"half a shore, key column wet", "~g~g    ", kWater},
        {"half a shore, key column dry", "g~g~    ", kGrass},
        {"an overhanging rock", "     R  ", kRock},
        {"a stone of the ground", " R      ", kAir},
        {"a puddle", "~~~     ", kAir},
    }));
    DYNAMIC_SECTION(c.name) {
        MaterialGrid grid;
        grid.set(40, 200, 40, kWall);  // so that there is a box
        for (int child = 0; child < 8; ++child)
            if (const char letter = c.children.at(static_cast<std::size_t>(child)); letter != ' ')
                grid.set(6 + child % 2, 10 + child / 4, 8 + child / 2 % 2, materials.at(letter));
        CHECK(material_name(material_at(*make_level(grid.build(), 1), 3, 5, 4)) ==
              material_name(c.expected));
    }
}
