#include "voxelserver/make/worlds/procedural/procedural_world.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "common/util/error.hpp"
#include "common/voxel/coarse_rule.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/make/worlds/procedural/world_levels.hpp"
#include "voxelserver/make/worlds/procedural/columns.hpp"
#include "voxelserver/make/worlds/procedural/noise.hpp"

using namespace terravox;
using namespace terravox::procedural;
using namespace terravox::voxel;
using terravox::test::contains;

namespace {

bool same(const std::shared_ptr<const Box>& a, const std::shared_ptr<const Box>& b) {
    if (!a || !b)
        return !a && !b;
    return std::equal(a->blob().begin(), a->blob().end(), b->blob().begin(), b->blob().end());
}

Settings seeded(std::uint64_t seed) {
    Settings s;
    s.seed = seed;
    return s;
}

}  // namespace

TEST_CASE("a generated world is not georeferenced, wide bounds and a small frame",
          "[raytracer][generated]") {
    const auto world = open_procedural_world({});
    const WorldInfo& info = world->info();
    CHECK(info.crs.empty());
    CHECK(!info.centre);
    CHECK(info.bounds.min[0] == -(1 << 24));
    CHECK(info.bounds.max[2] == 1 << 24);
    CHECK(info.levels == kMaxLevel);
    const BoxRange top = boxes_over(info.bounds, info.levels - 1);
    CHECK(top.max.bx - top.min.bx == 2);
    CHECK(info.framed.max[0] - info.framed.min[0] == 512);
    for (std::size_t a = 0; a < 3; ++a) {
        CHECK(info.framed.min[a] >= info.bounds.min[a]);
        CHECK(info.framed.max[a] <= info.bounds.max[a]);
    }
    CHECK_THROWS_AS(open_procedural_world({.harmonics = 99}), util::UsageError);
    CHECK_THROWS_AS(world->box({info.levels, 0, 0, 0}), util::UsageError);
    CHECK_THROWS_AS(world->box({-1, 0, 0, 0}), util::UsageError);
    world->stop();
    CHECK_THROWS_WITH(world->box({0, 0, 0, 0}), contains("interrupted"));
}

TEST_CASE("a box of a generated world is the same in whatever order boxes are requested",
          "[raytracer][generated]") {
    std::vector<BoxKey> keys;
    for (int level : {0, 1, 2, 3, 7})
        for (int i = 0; i < 8; ++i)
            keys.push_back({level, (i & 1) - 1, (i >> 1 & 1) - 1, (i >> 2) - 1});
    const auto first = open_procedural_world(seeded(3));
    const auto second = open_procedural_world(seeded(3));
    const auto other = open_procedural_world(seeded(4));
    std::vector<std::shared_ptr<const Box>> boxes;
    for (const BoxKey& key : keys)
        boxes.push_back(first->box(key));
    int differing = 0;
    for (std::size_t i = keys.size(); i-- > 0;) {
        INFO(to_string(keys[i]));
        CHECK(same(boxes[i], second->box(keys[i])));
        differing += !same(boxes[i], other->box(keys[i]));
    }
    CHECK(differing > 16);
}

TEST_CASE("a generated world has the same bits on every machine", "[raytracer][generated]") {
    // Whoever changes the look of the worlds on purpose writes the new numbers here.
    struct Case {
        BoxKey key;
        std::uint64_t checksum;
    };
    const auto world = open_procedural_world(seeded(1));
    for (const Case& c :
         {Case{{0, 0, 0, 0}, 0xAE974D0B9392D8E4ULL}, Case{{0, -3, -1, 2}, 0xA3A4D485DD1FCA51ULL},
          Case{{2, 1, 0, -1}, 0xC8179255398A5980ULL}, Case{{9, 0, -1, 0}, 0xA6DB0F7345B3FDF3ULL}}) {
        INFO(to_string(c.key));
        const auto box = world->box(c.key);
        REQUIRE(box);
        CHECK(box->checksum() == c.checksum);
    }
    CHECK(std::bit_cast<std::uint64_t>(simplex(1, -1234.5, 98765.4321)) == 0xBFD65D4FBEED82EAULL);
    CHECK(std::bit_cast<std::uint64_t>(simplex(0xFFFF'FFFF'FFFF'FFFFULL, 3.5, -0.125, 1e6 + 0.3)) ==
          0x3FDDAFD95783C261ULL);
}

TEST_CASE("neighbouring boxes of a generated world agree on their columns",
          "[raytracer][generated]") {
    const ColumnMaker maker(seeded(5));
    for (const int level : {0, 1, 2, 3, 6, 12}) {
        const Columns here = maker.make(level, 0, -1);
        const Columns east = maker.make(level, 1, -1);
        const Columns south = maker.make(level, 0, 0);
        int voxels = 0;
        const auto compare = [&](const Columns& a, int ax, int az, const Columns& b, int bx,
                                 int bz) {
            const Column &ca = a.at(ax, az), &cb = b.at(bx, bz);
            REQUIRE(ca.top == cb.top);
            REQUIRE(ca.water == cb.water);
            std::set<std::int32_t> ys;
            for (int y = ca.top - 5; y < std::max(ca.top, ca.water); ++y)
                ys.insert(y);
            for (const auto* columns : {&a, &b}) {
                const auto& runs = columns->runs();
                for (std::int32_t i = columns == &a ? ca.first_run : cb.first_run; i >= 0;
                     i = runs[static_cast<std::size_t>(i)].next)
                    for (std::int32_t y = runs[static_cast<std::size_t>(i)].y0;
                         y < runs[static_cast<std::size_t>(i)].y1; ++y)
                        ys.insert(y);
            }
            for (const std::int32_t y : ys) {
                INFO("level " << level << " column " << ax << ", " << az << " y " << y);
                REQUIRE(a.attr(ax, y, az) == b.attr(bx, y, bz));
                ++voxels;
            }
        };
        for (int i = -1; i <= 64; ++i)
            for (int side = -1; side <= 0; ++side) {
                compare(here, 64 + side, i, east, side, i);
                compare(here, i, 64 + side, south, i, side);
            }
        CHECK(voxels > 1000);
    }
}

TEST_CASE("levels of a generated world that are made by themselves look like downsampled ones",
          "[raytracer][generated]") {
    for (const std::uint64_t seed : {1}) {
        const auto world = open_procedural_world(seeded(seed));
        for (const int level : {1, 2, 3}) {
            test::FromAbove direct;
            test::FromAbove made;
            for (int i = 0; i < 16 >> level; ++i) {
                const std::int32_t bx = (i & 1) - 1;
                const std::int32_t bz = (i >> 1) - 1;
                direct.add(test::from_above(level, bx, bz, -1, 1,
                                            [&](const BoxKey& k) { return world->box(k); }));
                made.add(test::from_above(level, bx, bz, -1, 1, [&](const BoxKey& k) {
                    return test::downsampled(*world, k);
                }));
            }
            INFO("seed " << seed << ", level " << level);
            REQUIRE(direct.columns == 16 >> level << 12);
            REQUIRE(made.columns == direct.columns);
            // Heights are rounded to whole voxels, by other rules: a fifth of a voxel on the mean.
            CHECK(std::abs(direct.ground - made.ground) / made.columns < 0.25 * (1 << level));
            std::map<Material, int> all = direct.materials;
            all.insert(made.materials.begin(), made.materials.end());
            for (const auto& [material, count] : all) {
                INFO(material_name(material)
                     << ": " << direct.share(material) << ", downsampled " << made.share(material));
                CHECK(std::abs(direct.share(material) - made.share(material)) < 0.03);
            }
            for (std::size_t i = 0; i < 3; ++i)
                CHECK(std::abs(direct.channel(i) - made.channel(i)) < 4);
        }
    }
}

TEST_CASE("woods, seas and snow of a generated world keep their shares far away",
          "[raytracer][generated]") {
    const auto world = open_procedural_world(seeded(2));
    const auto all = [&](int level, int boxes) {
        test::FromAbove out;
        for (int bz = -boxes; bz < boxes; ++bz)
            for (int bx = -boxes; bx < boxes; ++bx)
                out.add(test::from_above(level, bx, bz, -1, 1,
                                         [&](const BoxKey& k) { return world->box(k); }));
        return out;
    };
    // The same columns: 4096 x 4096 about the origin.
    const test::FromAbove near = all(3, 4);
    const test::FromAbove far = all(5, 1);
    for (const Material material : {Material::kHighVegetation, Material::kWater, Material::kSnow,
                                    Material::kSand, Material::kRock, Material::kGrass}) {
        INFO(material_name(material)
             << ": level 3 " << near.share(material) << ", level 5 " << far.share(material));
        CHECK(std::abs(near.share(material) - far.share(material)) < 0.04);
    }
    // At the horizon a voxel is larger than any mountain: the ground stays where it is, within half
    // a voxel, and there is no gap.
    for (const int level : {8, 12, 16, kMaxLevel - 1}) {
        const test::FromAbove horizon =
            test::from_above(level, -1, 0, -1, 1, [&](const BoxKey& k) { return world->box(k); });
        INFO("level " << level);
        CHECK(horizon.columns == 4096);
        CHECK(std::abs(horizon.ground / horizon.columns) <= std::ldexp(1.0, level));
        CHECK(horizon.share(Material::kWater) > 0.1);
        CHECK(horizon.share(Material::kWater) < 0.7);
    }
}

TEST_CASE("water of a generated world lies flat at its level on all levels, above a bed",
          "[raytracer][generated]") {
    for (const int sea : {0, 64, -200}) {
        Settings settings = seeded(8);
        settings.water_level = sea;
        const ColumnMaker maker(settings);
        int wet = 0;
        for (const int level : {0, 1, 3, 5}) {
            const Columns columns = maker.make(level, -1, 0);
            for (int i = 0; i < 4096; ++i) {
                const Column& c = columns.at(i & 63, i >> 6);
                const auto surface =
                    static_cast<std::int32_t>(std::floor(std::ldexp(sea, -level) + 0.5));
                if (c.water == c.top) {
                    if (c.top < surface)
                        FAIL_CHECK("dry below the sea: level " << level << ", column " << i
                                                               << ", top " << c.top << ", sea "
                                                               << surface);
                    continue;
                }
                ++wet;
                if (c.water != surface || c.top >= surface)
                    FAIL_CHECK("level " << level << ", column " << i << ": water " << c.top
                                        << " to " << c.water << ", sea " << surface);
            }
        }
        INFO("sea " << sea);
        CHECK(wet > 100);
    }
}

TEST_CASE("plants of a generated world stand on ground, are of many kinds, and can be left out",
          "[raytracer][generated]") {
    const Settings with = seeded(1);
    Settings without = with;
    without.trees = false;
    const Terrain terrain(with);
    const Surface surface(terrain);
    const Vegetation vegetation(terrain);
    std::map<TreeKind, int> kinds;
    for (std::int32_t cell = 0; cell < 200'000; ++cell) {
        const auto spot = vegetation.spot(cell % 447 * 9 - 2000, cell / 447 * 9 - 2000);
        if (!vegetation.possible(spot))
            continue;
        const auto height = [&](int dx, int dz) {
            const double x = spot.x + dx + 0.5;
            const double z = spot.z + dz + 0.5;
            return terrain.heights(terrain.region(x, z), x, z, 1).full;
        };
        const Region region = terrain.region(spot.x + 0.5, spot.z + 0.5);
        const Place place =
            surface.place(region, spot.x, spot.z, height(0, 0), height(3, 0), height(0, 3));
        const auto tree = vegetation.tree(spot, place, surface.skin(place));
        if (!tree)
            continue;
        ++kinds[tree->kind];
        if (tree->base < with.water_level)
            FAIL_CHECK("a tree in the water at " << tree->x << ", " << tree->z);
        for (int d = -kTreeReach - 1; d <= kTreeReach + 1; ++d) {
            // Nothing reaches farther than the bounds say, and what is farthest is found by the
            // columns about it.
            const TreeRuns runs = tree_runs(*tree, d, kTreeReach + 1);
            if (runs.count != 0)
                FAIL_CHECK("a plant reaches " << d << ", " << kTreeReach + 1);
        }
        const TreeRuns stem = tree_runs(*tree, 0, 0);
        REQUIRE(stem.count > 0);
        CHECK(stem.runs[0].y0 == 0);
        CHECK(stem.runs[static_cast<std::size_t>(stem.count - 1)].y1 <= kTreeHeight);
    }
    CHECK(kinds.size() == 7);
    const auto bare = open_procedural_world(without);
    for (const int level : {0, 2, 4})
        for (int i = 0; i < 4; ++i) {
            const auto box = bare->box({level, (i & 1) - 1, 0, (i >> 1) - 1});
            if (!box)
                continue;
            CHECK(std::none_of(box->attrs().begin(), box->attrs().end(), [](const VoxelAttr& a) {
                return to_grain(a.material) == Grain::kSparse;
            }));
        }
}

TEST_CASE("a generated world has boxes for any settings, to its very edges",
          "[raytracer][generated][all]") {
    for (int i = 0; i < 14; ++i) {
        const std::uint64_t h = mix(static_cast<std::uint64_t>(i) + 77);
        const auto pick = [&](int part, double low, double high) {
            return i < 8 ? (i >> (part % 3) & 1 ? high : low)
                         : low + (high - low) * to_unit(h, part);
        };
        Settings s;
        s.seed = h;
        s.water_level = static_cast<int>(pick(0, -4096, 4096));
        s.world_height = static_cast<int>(pick(1, 8, 4096));
        s.harmonics = static_cast<int>(pick(2, 1, 16));
        s.frequency = pick(3, 1e-5, 0.1);
        s.smoothness = pick(4, 0, 1);
        INFO("settings " << i << ": water " << s.water_level << ", height " << s.world_height
                         << ", harmonics " << s.harmonics << ", frequency " << s.frequency
                         << ", smoothness " << s.smoothness);
        const auto world = open_procedural_world(s);
        for (const int level : {0, 3, world->info().levels - 1}) {
            const BoxRange range = boxes_over(world->info().bounds, level);
            for (const std::int32_t bx : {range.min.bx, 0, range.max.bx - 1}) {
                const std::int32_t bz = bx == 0 ? range.max.bz - 1 : bx;
                const ColumnExtent extent = world->column(level, bx, bz);
                REQUIRE(extent.by_begin == range.min.by);
                REQUIRE(extent.by_end == range.max.by);
                const test::FromAbove seen =
                    test::from_above(level, bx, bz, range.min.by, range.max.by,
                                     [&](const BoxKey& k) { return world->box(k); });
                CHECK(seen.columns == 4096);
                CHECK(world->box({level, bx, range.max.by, bz}) == nullptr);
            }
            CHECK(world->box({level, range.max.bx, range.min.by, 0}) == nullptr);
            CHECK(world->box({level, 0, range.min.by, range.min.bz - 1}) == nullptr);
        }
    }
}
