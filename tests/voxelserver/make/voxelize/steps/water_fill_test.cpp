// Which columns are water, how high it stands and how deep it is.
#include <cmath>
#include <set>

#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/steps/made_land.hpp"
#include "voxelserver/make/voxelize/steps/water_fill.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;

namespace {

using Returns = MadeLand::Returns;

/// A round lake in flat ground; one in eight columns of it returns something, at a level with
/// noise.
struct Lake {
    int mid_x = 32;
    int mid_z = 32;
    double radius = 20;
    double level = 100.4;
    [[nodiscard]] double distance(int x, int z) const { return std::hypot(x - mid_x, z - mid_z); }
    [[nodiscard]] bool holds(int x, int z) const { return distance(x, z) < radius; }
    void returns(int x, int z, Returns& out) const {
        if (!holds(x, z))
            out.push_back({level + 0.8, kGroundClass});
        else if (dice(x, z, 5) < 0.125)
            out.push_back({level + 0.2 * (dice(x, z, 6) - 0.5), kWater});
    }
};

/// Everything that finds the water of a land.
class Finder {
public:
    explicit Finder(MadeLand::ReturnsAt returns, double voxel_m = 1)
        : m_land(std::move(returns)), m_voxel_m(voxel_m) {
        m_land.limit(
            [](std::int32_t x, std::int32_t z) { return std::abs(x) < 300 && std::abs(z) < 300; });
    }
    [[nodiscard]] WaterColumns at(grid::PatchKey patch, const Settings& settings = {}) {
        water::WaterOptions options;
        options.cell_voxels = m_land.cell_voxels();
        options.voxel_m = m_voxel_m;
        water::WaterBodies bodies(m_land, options);
        WaterAccess access{m_land, bodies, m_land.cell_voxels()};
        WaterAccess* const followed = settings.steps.water_equalization ? &access : nullptr;
        const Window window = m_land.window(patch);
        WaterColumns out = fill_water(window, followed);
        if (settings.steps.water_deepening)
            deepen_water(window, followed, settings.water, m_voxel_m, out);
        else
            level_bed(settings.water.min_depth_m, out);
        return out;
    }

private:
    MadeLand m_land;
    double m_voxel_m;
};

}  // namespace

TEST_CASE("a lake is all water at one level, and its shore is none",
          "[voxelserver][voxelize][water]") {
    struct Case {
        const char* name;
        Lake lake;
    };
    const auto c = GENERATE(values<Case>({{"inside a patch", {}},
                                          {"across a corner", {0, 64, 25, -3.2}},
                                          {"as wide as a patch", {32, 32, 60, 250.9}}}));
    DYNAMIC_SECTION(c.name) {
        Finder finder([&](int x, int z, Returns& out) { c.lake.returns(x, z, out); });
        const auto water = finder.at({0, 0});
        std::set<float> levels;
        int wet = 0;
        Grid<float, WaterColumns::kMargin>::each([&](int x, int z) {
            INFO("column " << x << ", " << z << ", " << c.lake.distance(x, z)
                           << " from the middle");
            if (!c.lake.holds(x, z)) {
                REQUIRE_FALSE(water.is_water(x, z));
                return;
            }
            // A cell that the shore cuts through may be the land's.
            if (c.lake.distance(x, z) < c.lake.radius - 3)
                REQUIRE(water.is_water(x, z));
            if (water.is_water(x, z)) {
                levels.insert(water.level.at(x, z));
                ++wet;
            }
        });
        CHECK(wet > 400);
        REQUIRE(levels.size() == 1);
        CHECK(std::abs(*levels.begin() - c.lake.level) < 0.1);
    }
}

TEST_CASE("a boathouse and an island stand in the lake, and a footbridge lets it be",
          "[voxelserver][voxelize][water]") {
    const Lake lake;
    const auto island = [](int x, int z) { return std::hypot(x - 42, z - 27) < 6; };
    Finder finder([&](int x, int z, Returns& out) {
        if (x >= 28 && x < 34 && z >= 28 && z < 33)
            out.insert(out.end(), {{105, kBuilding}, {105.2, kBuilding}});
        else if (island(x, z))
            out.push_back({101, kGroundClass});
        else
            lake.returns(x, z, out);
        if (z == 40)
            out.push_back({103, kBridge});
    });
    const auto water = finder.at({0, 0});
    for (int z = 28; z < 33; ++z)
        for (int x = 28; x < 34; ++x)
            CHECK_FALSE(water.is_water(x, z));
    for (int x = 20; x < 45; ++x) {
        INFO("under the bridge at " << x);
        CHECK(water.is_water(x, 40));
    }
    CHECK(water.is_water(32, 25));
    Margined<float>::each([&](int x, int z) {
        if (island(x, z))
            REQUIRE_FALSE(water.is_water(x, z));
    });
}

TEST_CASE("with equalization off water stands where it was seen, column by column",
          "[voxelserver][voxelize][water]") {
    const Lake lake;
    MadeLand land([&](int x, int z, Returns& out) { lake.returns(x, z, out); });
    const Window window = land.window({0, 0});
    const auto water = fill_water(window, nullptr);
    std::set<float> levels;
    Grid<float, WaterColumns::kMargin>::each([&](int x, int z) {
        REQUIRE(water.is_water(x, z) == window.column(x, z).water.seen());
        if (!water.is_water(x, z))
            return;
        REQUIRE(water.level.at(x, z) == window.column(x, z).water.height);
        levels.insert(water.level.at(x, z));
    });
    CHECK(levels.size() > 50);
}

TEST_CASE("the bed falls away from the shore as the settings say",
          "[voxelserver][voxelize][water]") {
    struct Case {
        const char* name;
        double voxel_m;
        double slope;
        double min_m;
        double max_m;
        bool deepening;
    };
    const auto c = GENERATE(values<Case>({{"usual", 1, 0.3, 0.6, 8, true},
                                          {"steep and shallow", 1, 2, 0.5, 3, true},
                                          {"half metres", 0.5, 0.3, 0.6, 8, true},
                                          {"switched off", 1, 0.3, 0.6, 8, false}}));
    DYNAMIC_SECTION(c.name) {
        Settings settings;
        settings.water.slope = c.slope;
        settings.water.min_depth_m = c.min_m;
        settings.water.max_depth_m = c.max_m;
        settings.steps.water_deepening = c.deepening;
        const Lake lake{32, 32, 50, 100};
        Finder finder([&](int x, int z, Returns& out) { lake.returns(x, z, out); }, c.voxel_m);
        const auto water = finder.at({0, 0}, settings);
        Margined<float>::each([&](int x, int z) {
            const double shore_m =
                std::min(lake.radius - lake.distance(x, z), 1.0 * kShoreReach) * c.voxel_m;
            const double depth = water.depth_m.at(x, z);
            INFO("column " << x << ", " << z << ", " << shore_m << " m from the shore");
            if (!water.is_water(x, z))
                return;
            // The shore runs along cells of two columns.
            const double low = std::clamp((shore_m - 4 * c.voxel_m) * c.slope, c.min_m, c.max_m);
            const double high = std::clamp((shore_m + 2 * c.voxel_m) * c.slope, c.min_m, c.max_m);
            if (c.deepening)
                REQUIRE((depth >= low - 1e-4 && depth <= high + 1e-4));
            else
                REQUIRE(depth == Approx(c.min_m));
        });
    }
}
