#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <thread>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/data/water/landscapes.hpp"
#include "voxelserver/data/water/body_finder.hpp"

using namespace terravox;
using namespace terravox::water;
using namespace terravox::water::test;

namespace {

constexpr int kSide = 32;

// Two rivers, a lake and many small voids, around the origin so that indices of both signs occur.
class Scene {
public:
    static constexpr int kWidth = 420;
    static constexpr int kHeight = 300;
    static constexpr int kX0 = -200;
    static constexpr int kZ0 = -140;
    explicit Scene(std::uint32_t seed) : m_land(kWidth, kHeight, seed) {
        m_land.river(wave(5, 410, 90, 40, 200), 5, 60, 0.02);
        m_land.lake({330, 230}, 35, 44);
        m_land.river(line({10, 200}, {250, 280}), 2, 52, 0.01);
        m_cells = m_land.scan();
        for (int i = 0; i < 900; ++i) {
            const auto k =
                static_cast<std::size_t>(m_land.uniform() * static_cast<double>(m_cells.size()));
            if (m_cells[k].ground_points > 0)
                m_cells[k] = m_land.uniform() < 0.5 ? nothing_seen() : wet(m_cells[k]);
        }
    }
    [[nodiscard]] WaterCell operator()(std::int32_t x, std::int32_t z) const {
        return m_land.inside(x - kX0, z - kZ0) ? m_cells[m_land.index(x - kX0, z - kZ0)]
                                               : WaterCell{};
    }

private:
    Landscape m_land;
    std::vector<WaterCell> m_cells;
};

// The levels of the cells of a patch, and how far they reach together.
struct Told {
    std::vector<float> levels;
    voxel::InputExtent reach;
};

using Picture = std::map<std::pair<int, int>, Told>;

bool same(const std::vector<float>& a, const std::vector<float>& b) {
    if (a.size() != b.size())
        return false;
    for (std::size_t i = 0; i < a.size(); ++i)
        if (a[i] != b[i] && !(std::isnan(a[i]) && std::isnan(b[i])))
            return false;
    return true;
}

std::vector<std::pair<int, int>> list_patches(int from, int to) {
    std::vector<std::pair<int, int>> out;
    for (int z = from; z < to; ++z)
        for (int x = from; x < to; ++x)
            out.emplace_back(x, z);
    return out;
}

Told ask(WaterBodies& bodies, std::pair<int, int> p, int side = kSide) {
    Told out;
    for (int z = 0; z < side; ++z)
        for (int x = 0; x < side; ++x)
            out.levels.push_back(bodies.level(p.first * side + x, p.second * side + z, &out.reach));
    return out;
}

std::size_t wet_cells(const Told& told) {
    return static_cast<std::size_t>(std::count_if(told.levels.begin(), told.levels.end(),
                                                  [](float l) { return !std::isnan(l); }));
}

Picture picture(WaterBodies& bodies, std::vector<std::pair<int, int>> order) {
    Picture out;
    for (const auto& p : order)
        out[p] = ask(bodies, p);
    return out;
}

void check_same(const Picture& a, const Picture& b) {
    REQUIRE(a.size() == b.size());
    for (const auto& [patch, told] : a) {
        INFO("patch " << patch.first << ", " << patch.second);
        REQUIRE(same(told.levels, b.at(patch).levels));
        REQUIRE(told.reach == b.at(patch).reach);
    }
}

constexpr int kReachSide = 8;  // cells along a patch

using Wet = bool (*)(std::int32_t, std::int32_t);

/// Water where `wet` says so, flat ground elsewhere; nothing beyond 12 patches.
FunctionSource::Make made(Wet wet) {
    return [wet](std::int32_t x, std::int32_t z) {
        if (std::abs(x >> 3) > 12 || std::abs(z >> 3) > 12)
            return WaterCell{};
        return wet(x, z) ? water_at(5, 4) : ground_at(7, 16);
    };
}

WaterOptions reach_options(std::size_t max_patches = 16384) {
    WaterOptions out;
    out.cell_voxels = 64 / kReachSide;
    out.max_body_patches = max_patches;
    return out;
}

}  // namespace

TEST_CASE(
    "levels and reaches depend neither on which request comes first, nor on threads, nor on memory",
    "[water][finder]") {
    const Scene scene(5);
    const auto cells = std::ref(scene);
    FunctionSource reference_source(kSide, cells);
    WaterBodies reference(reference_source, {});
    const Picture expected = picture(reference, list_patches(-8, 9));
    const bool forgets = GENERATE(false, true);
    INFO((forgets ? "forgets all the time" : "remembers all"));
    FunctionSource source(kSide, cells);
    WaterOptions options;
    if (forgets)
        options.memory_bytes = 20'000;
    WaterBodies bodies(source, options);
    std::mt19937 random(3);
    for (int i = 0; i < 200; ++i) {
        const auto x = static_cast<std::int32_t>(random() % 500) - 250;
        const auto z = static_cast<std::int32_t>(random() % 500) - 250;
        const float level = bodies.level(x, z);
        const float other = expected.at({x >> 5, z >> 5})
                                .levels[static_cast<std::size_t>((z & 31) * 32 + (x & 31))];
        INFO("cell " << x << ", " << z << ": " << level << " and " << other);
        REQUIRE(same({level}, {other}));
    }
    std::vector<Picture> found(3);
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < found.size(); ++t)
        threads.emplace_back([&, t] {
            auto order = list_patches(-8, 9);
            std::shuffle(order.begin(), order.end(), std::mt19937(static_cast<unsigned>(t)));
            found[t] = picture(bodies, order);
        });
    for (auto& t : threads)
        t.join();
    for (const Picture& p : found)
        check_same(p, expected);
}

TEST_CASE("a body too large for the bound is cut the same way whichever request comes first",
          "[water][finder]") {
    const Scene scene(7);
    const auto cells = std::ref(scene);
    WaterOptions options;
    options.max_body_patches = 20;  // squares of 4 x 4 patches
    FunctionSource first_source(kSide, cells);
    WaterBodies first(first_source, options);
    const Picture expected = picture(first, list_patches(-8, 9));
    FunctionSource whole_source(kSide, cells);
    WaterBodies whole(whole_source, {});
    const Picture uncut = picture(whole, list_patches(-8, 9));
    bool differs = false;
    for (const auto& [patch, told] : uncut) {
        const std::vector<float>& levels = told.levels;
        const std::vector<float>& cut = expected.at(patch).levels;
        differs = differs || !same(cut, levels);
        // The same water, at levels that differ by what the cutting costs.
        REQUIRE(cut.size() == levels.size());
        for (std::size_t i = 0; i < cut.size(); ++i) {
            REQUIRE(std::isnan(cut[i]) == std::isnan(levels[i]));
            if (!std::isnan(cut[i]))
                REQUIRE(std::abs(cut[i] - levels[i]) < 0.5f);
        }
    }
    CHECK(differs);
    std::mt19937 random(3);
    for (int round = 0; round < 2; ++round) {
        auto order = list_patches(-8, 9);
        std::shuffle(order.begin(), order.end(), random);
        FunctionSource source(kSide, cells);
        WaterBodies bodies(source, options);
        check_same(picture(bodies, order), expected);
    }
}

TEST_CASE("a dry patch loads no neighbour", "[water][finder]") {
    FunctionSource source(kSide, [](auto x, auto z) {
        return x == 5 && z == 5 ? nothing_seen() : x == 40 && z == 20 ? water_at(3) : ground_at(10);
    });
    WaterBodies bodies(source, {});
    CHECK(wet_cells(ask(bodies, {0, 0})) == 0);
    CHECK(std::isnan(bodies.level(3, 31)));
    CHECK(std::isnan(bodies.level_near(6, 6)));
    CHECK(source.requested() == std::set<std::pair<std::int32_t, std::int32_t>>{{0, 0}});
    CHECK(wet_cells(ask(bodies, {1, 0})) == 1);
    CHECK(bodies.level(40, 20) == 3);
    CHECK(source.requested().size() == 2);
}

TEST_CASE("a column next to the water finds its level", "[water][finder]") {
    FunctionSource source(kSide, [](auto x, auto z) {
        return x >= 60 && x < 70 && z >= -5 && z < 5 ? water_at(3) : ground_at(10);
    });
    WaterBodies bodies(source, {});
    CHECK(bodies.level(60, -5) == 3);
    CHECK(std::isnan(bodies.level(59, -5)));
    CHECK(bodies.level_near(59, -5) == 3);
    CHECK(bodies.level_near(70, 5) == 3);
    CHECK(std::isnan(bodies.level_near(71, 5)));
}

TEST_CASE(
    "a body of a million cells over thousands of patches is found at once and remembered within "
    "bounds",
    "[water][finder]") {
    // A meander: runs of 3 patches' width from west to east and back, so that it touches 60 x 60
    // patches.
    const int side = 16;
    const int span = 60 * side;
    const auto make = [&](std::int32_t x, std::int32_t z) {
        if (x < 0 || z < 0 || x >= span || z >= span)
            return WaterCell{};
        const int row = z / 48;
        const int in_row = z % 48;
        const bool gap = row % 2 == 0 ? x >= span - 40 : x < 40;
        if (in_row >= 46 && !gap)
            return ground_at(300);
        const double along =
            (row + (row % 2 == 0 ? x : span - x) / static_cast<double>(span)) * span;
        const double noise = 0.05 * (static_cast<double>((x * 7919 + z * 104729) % 1000) / 500 - 1);
        return (x * 31 + z * 17) % 4 == 0
                   ? water_at(static_cast<float>(200 - along * 0.004 + noise))
                   : nothing_seen();
    };
    FunctionSource source(side, make);
    WaterOptions options;
    options.cell_voxels = 4;
    for (int p = 0; p < 60 * 60; ++p)
        (void)source.cells(p % 60, p / 60);  // made beforehand: not what is measured
    WaterBodies bodies(source, options);
    const float top = bodies.level(0, 20);
    const float bottom = bodies.level(20, span - 5);
    CHECK(top == Approx(200).margin(0.5));
    CHECK(bottom == Approx(200 - 20 * span * 0.004).margin(0.5));
    CHECK(bodies.memory_bytes() < 3600u * (16 * 16 * 6 + 216) + 1);
    std::size_t cells = 0;
    for (int p = 0; p < 60 * 60; ++p)
        cells += wet_cells(ask(bodies, {p % 60, p / 60}, side));
    CHECK(cells > 880'000);
}

TEST_CASE("the finder stands up to hostile cells", "[water][finder]") {
    struct Case {
        const char* name;
        FunctionSource::Make make;
    };
    const float nan = kNoLevel;
    const float inf = std::numeric_limits<float>::infinity();
    const auto c = GENERATE_COPY(values<Case>({
        {"nothing but covered voids, without end", [](auto, auto) { return nothing_seen(); }},
        {"nothing covered", [](auto, auto) { return WaterCell{}; }},
        {"water returns without a height, without end", [=](auto, auto) { return water_at(nan); }},
        {"water at infinity, without end", [=](auto, auto) { return water_at(inf); }},
        {"wet ground without a height", [=](auto, auto) { return wet(ground_at(nan)); }},
        {"a shore of NaN",
         [=](auto x, auto z) {
             return x > 3 && z > 3 && x < 25 && z < 25 ? nothing_seen() : ground_at(nan);
         }},
        {"a chessboard of voids",
         [](auto x, auto z) { return (x + z) % 2 == 0 ? nothing_seen() : ground_at(1); }},
    }));
    DYNAMIC_SECTION(c.name) {
        FunctionSource source(kSide, c.make);
        WaterOptions options;
        options.max_body_patches = 64;
        WaterBodies bodies(source, options);
        for (const auto& [x, z] : {std::pair{0, 0}, {1, 0}, {-40, 7}, {1000, -1000}, {16, 16}})
            CHECK(std::isnan(bodies.level(x, z)));
        CHECK(wet_cells(ask(bodies, {0, 0})) == 0);
        CHECK(wet_cells(ask(bodies, {-1, -1})) == 0);
    }
    FunctionSource extreme(kSide, [](auto, auto) { return water_at(3e38f, 65535); });
    WaterOptions options;
    options.max_body_patches = 16;
    WaterBodies bodies(extreme, options);
    CHECK(bodies.level(0, 0) == 3e38f);
}

TEST_CASE("the finder refuses options and sources it cannot work with", "[water][finder]") {
    FunctionSource source(kSide, [](auto, auto) { return ground_at(1); });
    WaterOptions options;
    options.cell_voxels = 3;
    CHECK_THROWS_WITH(WaterBodies(source, options), terravox::test::contains("3 voxels") &&
                                                        terravox::test::contains("divisor of 64"));
    options.cell_voxels = 4;
    WaterBodies other_size(source, options);
    CHECK_THROWS_WITH(other_size.level(0, 0), terravox::test::contains("1024 cells") &&
                                                  terravox::test::contains("16 x 16"));
    options.voxel_m = std::numeric_limits<double>::quiet_NaN();
    CHECK_THROWS_AS(WaterBodies(source, options), util::Error);
    options.voxel_m = 1;
    options.max_body_patches = 3;
    CHECK_THROWS_AS(WaterBodies(source, options), util::Error);

    int left = 3;  // a source that fails once: the next question is answered
    FunctionSource failing(kSide, [&](std::int32_t x, std::int32_t) {
        if (x >= 32 && left > 0)
            --left, throw util::Error("read points: no");
        return x < 40 ? water_at(2) : ground_at(9);
    });
    WaterOptions small;
    small.max_body_patches = 16;
    WaterBodies bodies(failing, small);
    CHECK_THROWS_AS(bodies.level(3, 3), util::Error);
    CHECK(bodies.memory_bytes() == 0);
    while (left > 0)
        CHECK_THROWS_AS(bodies.level(3, 3), util::Error);
    CHECK(bodies.level(3, 3) == 2);
}

TEST_CASE("a level reaches as far as its body and one patch beyond where the body touches a border",
          "[voxelserver][water][reach]") {
    struct Case {
        const char* name;
        Wet wet;
        std::int32_t cx;
        std::int32_t cz;
        voxel::InputExtent reach;
    };
    const Wet dry = [](std::int32_t, std::int32_t) { return false; };
    const Wet pond = [](std::int32_t x, std::int32_t z) {
        return x > 1 && x < 6 && z > 1 && z < 6;
    };
    const Wet wide = [](std::int32_t x, std::int32_t z) {
        return x > 1 && x < 8 && z > 1 && z < 6;
    };
    const Wet canal = [](std::int32_t x, std::int32_t z) { return z == 3 && x >= -30 && x < 42; };
    const auto c = GENERATE_COPY(values<Case>({
        {"dry land: its own patch", dry, 3, 3, {0, 0, 1, 1}},
        {"dry land south of 0", dry, -1, -9, {-1, -2, 0, -1}},
        {"a pond within a patch", pond, 3, 3, {0, 0, 1, 1}},
        {"a pond along a border", wide, 3, 3, {0, 0, 2, 1}},
        {"dry land next to that pond", wide, 0, 0, {0, 0, 1, 1}},
        {"a canal of nine patches", canal, 0, 3, {-4, 0, 6, 1}},
        {"the other end of it", canal, 41, 3, {-4, 0, 6, 1}},
    }));
    DYNAMIC_SECTION(c.name) {
        FunctionSource source(kReachSide, made(c.wet));
        WaterBodies bodies(source, reach_options());
        for (int i = 0; i < 2; ++i) {  // found, then remembered
            voxel::InputExtent reach;
            static_cast<void>(bodies.level(c.cx, c.cz, &reach));
            INFO(reach.min_bx << ", " << reach.min_bz << " to " << reach.max_bx << ", "
                              << reach.max_bz);
            CHECK(reach == c.reach);
        }
    }
}

TEST_CASE("a body that is cut reaches everywhere", "[voxelserver][water][reach]") {
    FunctionSource source(kReachSide, made([](std::int32_t x, std::int32_t z) {
                              return std::abs(x) < 90 && std::abs(z) < 90;
                          }));
    WaterBodies bodies(source, reach_options(16));
    voxel::InputExtent reach;
    CHECK(bodies.level(0, 0, &reach) == 5);
    CHECK(reach == kAnywhere);
}
