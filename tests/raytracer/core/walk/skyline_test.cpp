// What a skyline calls open must be empty, whatever is in memory.
#include "raytracer/core/walk/lane_walk.hpp"

#include "tests/catch.hpp"
#include "tests/raytracer/core/walk/walk_fixture.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

constexpr std::int32_t kWide = 300;
constexpr std::int32_t kHigh = 290;  // two boxes above each other

/// A plain with towers, one of which reaches into the upper boxes, and a plate that floats there.
std::unique_ptr<ArrayWorld> plain_with_towers() {
    auto world = std::make_unique<ArrayWorld>(ArrayWorld::Coord{-20, 0, -20},
                                              ArrayWorld::Coord{kWide, kHigh, kWide});
    world->fill({-20, 0, -20}, {kWide, 8, kWide}, voxel::Material::kGround);
    world->fill({10, 8, 10}, {20, 60, 20}, voxel::Material::kWall);
    world->fill({70, 8, 200}, {75, 270, 205}, voxel::Material::kWall);
    world->fill({130, 280, 130}, {140, 281, 140}, voxel::Material::kRoof);
    return world;
}

struct Place {
    explicit Place(std::shared_ptr<voxel::World> of, double detail = 0, int levels = 1)
        : world(std::move(of)),
          cut(world->info().bounds, {0, 60, 0}, 0.03, detail, 0, levels - 1),
          blocks(*world, std::size_t{1} << 30),
          reader(blocks),
          skyline(std::in_place, reader, cut) {}

    /// Brings all boxes into memory.
    void load() {
        for (int level = 0; level <= cut.coarsest(); ++level) {
            const voxel::BoxRange range = voxel::boxes_over(world->info().bounds, level);
            for (std::int32_t bx = range.min.bx; bx < range.max.bx; ++bx)
                for (std::int32_t by = range.min.by; by < range.max.by; ++by)
                    for (std::int32_t bz = range.min.bz; bz < range.max.bz; ++bz)
                        (void)blocks.get({level, bx, by, bz});
        }
    }
    /// Asks as often as makes a skyline look again.
    [[nodiscard]] int open_above(std::int32_t x, std::int32_t y, std::int32_t z) {
        core::RayState ray(core::Ray{{0, 0, 0}, core::normalized({1, 1, 1})});
        ray.change_scale(cut.level_at(x, z, 0));
        const std::int32_t at[3] = {x >> ray.level, y >> ray.level, z >> ray.level};
        std::copy(at, at + 3, ray.voxel);
        int open = 0;
        for (int i = 0; i < 200; ++i)
            open = skyline->open_above(ray);
        return open;
    }
    void ask_everywhere() {
        for (std::int32_t x = -20; x < kWide; x += 20)
            for (std::int32_t z = -20; z < kWide; z += 20)
                (void)open_above(x, kHigh - 1, z);
    }
    std::shared_ptr<voxel::World> world;
    walk::LevelCut cut;
    blocks::BlockManager blocks;
    walk::BlockReader reader;
    std::optional<walk::Skyline> skyline;
};

}  // namespace

TEST_CASE("a skyline knows columns whose boxes are in memory, and squares of known columns",
          "[raytracer][skyline]") {
    struct Case {
        const char* name;
        std::int32_t x, y, z;
        int alone;  ///< what is open when only this column has been asked about
        int open;   ///< when all have been
    };
    const Case cases[] = {
        {"on the plain", 100, 8, 30, 6, 6},
        {"in the plain", 100, 7, 30, 0, 0},
        {"over the low tower's top", 30, 60, 30, 6, 6},
        {"beside the low tower", 30, 59, 30, 0, 0},
        {"below the floating plate", 150, 100, 150, 0, 0},
        {"over the floating plate", 150, 281, 150, 6, 10},
        {"beside the high tower", 80, 200, 210, 0, 0},
        {"over the low tower, as high as the high one", 30, 270, 30, 6, 6},
        {"in a square of which one column is in the world", 280, 270, 280, 8, 8},
        {"the same, and the larger square's only one", -10, 8, -10, 10, 10},
    };
    Place place(plain_with_towers());
    const auto open = [&](const Case& c) { return place.open_above(c.x, c.y, c.z); };
    for (const Case& c : cases) {
        INFO(c.name);
        CHECK(open(c) == 0);
    }
    place.load();
    for (const Case& c : cases) {
        INFO(c.name);
        place.skyline.emplace(place.reader, place.cut);
        CHECK(open(c) == c.alone);
    }
    place.ask_everywhere();
    for (const Case& c : cases) {
        INFO(c.name);
        CHECK(open(c) == c.open);
    }
}

TEST_CASE("a box that is not available closes the sky, over its column alone",
          "[raytracer][skyline]") {
    auto world = plain_with_towers();
    world->make_hole({0, 1, 1, 1});
    Place place(std::move(world));
    place.load();
    place.ask_everywhere();
    CHECK(place.open_above(100, kHigh - 1, 100) == 0);
    CHECK(place.open_above(200, kHigh - 1, 100) == 6);
}

TEST_CASE("what a skyline calls open is empty on every level, and of one level",
          "[raytracer][skyline]") {
    constexpr int kOfLevels = 3;
    const auto solid = std::make_shared<PyramidWorld>(plain_with_towers(), kOfLevels);
    for (const double detail : {0.0, 1.0, 3.0}) {
        INFO("detail " << detail);
        Place place(solid, detail, kOfLevels);
        place.load();
        place.ask_everywhere();
        Random random(5);
        int wrong = 0;
        int open_places = 0;
        for (int i = 0; i < 400; ++i) {
            const auto x = static_cast<std::int32_t>(real(random, -20, kWide));
            const auto y = static_cast<std::int32_t>(real(random, 0, kHigh));
            const auto z = static_cast<std::int32_t>(real(random, -20, kWide));
            const int open = place.open_above(x, y, z);
            if (open == 0)
                continue;
            ++open_places;
            const int level = place.cut.level_at(x, z, 0);
            const std::int32_t low_x = x >> level >> open << open;
            const std::int32_t low_z = z >> level >> open << open;
            const auto inside = [&](std::int32_t v) {
                return v << level >= -20 && v << level < kWide;
            };
            for (int sample = 0; sample < 300; ++sample) {
                const auto side = static_cast<double>(std::int32_t{1} << open);
                const auto sx = low_x + static_cast<std::int32_t>(real(random, 0, side));
                const auto sz = low_z + static_cast<std::int32_t>(real(random, 0, side));
                const auto sy = static_cast<std::int32_t>(real(random, y >> level, kHigh >> level));
                if (!inside(sx) || !inside(sz))
                    continue;
                wrong += place.cut.level_at(sx << level, sz << level, 0) != level ? 1 : 0;
                wrong += solid->at(level, sx, sy, sz) != voxel::Material::kAir ? 1 : 0;
            }
        }
        CHECK(wrong == 0);
        CHECK(open_places > 100);
    }
}
