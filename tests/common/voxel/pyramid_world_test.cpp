#include "common/voxel/pyramid_world.hpp"

#include "common/thread/parallel.hpp"
#include "common/voxel/box_builder.hpp"
#include "tests/catch.hpp"
#include "tests/common/voxel/synthetic_world.hpp"

using namespace terravox;
using namespace terravox::voxel;
using terravox::test::same_box;
using terravox::test::SyntheticWorld;

namespace {

constexpr VoxelBounds kBounds{{-200, -5, 70}, {300, 300, 330}};

}  // namespace

TEST_CASE("a world has levels until it fits into one box across", "[common][voxel][pyramid]") {
    CHECK(levels_for({{0, 0, 0}, {64, 300, 64}}) == 1);
    CHECK(levels_for({{0, 0, 0}, {65, 300, 64}}) == 2);
    CHECK(levels_for({{-200, 0, 70}, {300, 9, 330}}) == 4);
    CHECK(levels_for({{-(1 << 30), 0, 0}, {1 << 30, 1, 1}}) <= kMaxLevel);
}

TEST_CASE("coarse boxes of a pyramid are made of their eight children",
          "[common][voxel][pyramid]") {
    SyntheticWorld world(kBounds);
    for (int level = 1; level < world.info().levels; ++level) {
        const BoxRange range = boxes_over(kBounds, level);
        for (std::int32_t bx = range.min.bx; bx < range.max.bx; ++bx)
            for (std::int32_t by = range.min.by; by < range.max.by; ++by)
                for (std::int32_t bz = range.min.bz; bz < range.max.bz; ++bz) {
                    std::array<std::shared_ptr<const Box>, 8> children;
                    for (int i = 0; i < 8; ++i)
                        children[static_cast<std::size_t>(i)] =
                            world.box({level - 1, 2 * bx + (i & 1), 2 * by + (i >> 2),
                                       2 * bz + (i >> 1 & 1)});
                    const BoxKey key{level, bx, by, bz};
                    INFO(to_string(key));
                    CHECK(same_box(world.box(key), downsample(key, children)));
                }
    }
}

TEST_CASE("a column is made once for all its boxes, and whatever the limit the boxes are the same",
          "[common][voxel][pyramid]") {
    SyntheticWorld roomy(kBounds), narrow(kBounds, 1);
    const BoxRange range = boxes_over(kBounds, 0);
    std::vector<BoxKey> keys;
    for (std::int32_t by = range.min.by; by < range.max.by; ++by)
        for (std::int32_t bx = range.min.bx; bx < range.max.bx; ++bx)
            for (std::int32_t bz = range.min.bz; bz < range.max.bz; ++bz)
                keys.push_back({0, bx, by, bz});
    thread::parallel_for(keys.size(), 4, [&](std::size_t i) { (void)roomy.box(keys[i]); });
    CHECK(roomy.made == (range.max.bx - range.min.bx) * (range.max.bz - range.min.bz));
    for (const BoxKey& key : keys)
        CHECK(same_box(roomy.box(key), narrow.box(key)));
    CHECK(narrow.made == static_cast<int>(keys.size()));
}

TEST_CASE("a pyramid reports where it is empty, however wide it is", "[common][voxel][pyramid]") {
    class Lone final : public PyramidWorld {
    public:
        Lone() : PyramidWorld(1 << 20) {
            constexpr std::int32_t kWide = 1 << 29;
            m_info.bounds = {{-kWide, 0, -kWide}, {kWide, 256, kWide}};
            m_info.levels = levels_for(m_info.bounds);
        }
        [[nodiscard]] const WorldInfo& info() const noexcept override { return m_info; }

    protected:
        [[nodiscard]] FineColumn make_column(std::int32_t, std::int32_t) override { return {}; }
        [[nodiscard]] bool may_hold_column(int level, std::int32_t bx,
                                           std::int32_t bz) const override {
            return bx == 1000 >> level && bz == -1000 >> level;
        }

    private:
        WorldInfo m_info;
    } world;
    const auto may_hold = [&](std::int32_t x0, std::int32_t z0, std::int32_t x1, std::int32_t z1) {
        return world.may_hold({{0, x0, 0, z0}, {0, x1, 1, z1}});
    };
    CHECK(may_hold(1000, -1000, 1001, -999));
    CHECK_FALSE(may_hold(1001, -1000, 1002, -999));
    CHECK_FALSE(may_hold(1000, -999, 1001, -998));
    CHECK(may_hold(900, -1100, 1100, -900));
    CHECK_FALSE(may_hold(5000, 5000, 5100, 5100));
    CHECK(may_hold(-(1 << 23), -(1 << 23), 1 << 23, 1 << 23));
    CHECK(SyntheticWorld(kBounds).may_hold({{0, -4, -1, 1}, {0, 5, 2, 6}}));
    CHECK_FALSE(SyntheticWorld(kBounds).may_hold({{0, 100, -1, 1}, {0, 105, 2, 6}}));
}

TEST_CASE("outside its bounds a pyramid is air, and other levels are refused",
          "[common][voxel][pyramid]") {
    SyntheticWorld world(kBounds);
    CHECK(world.box({0, 100, 0, 3}) == nullptr);
    CHECK(world.column(0, 100, 3).empty());
    CHECK_FALSE(world.column(0, 0, 3).empty());
    CHECK(world.made == 0);
    CHECK_THROWS_AS(world.box({world.info().levels, 0, 0, 0}), util::UsageError);
    CHECK_THROWS_AS(world.box({-1, 0, 0, 0}), util::UsageError);
}

TEST_CASE("what cannot be made is an error on every level above it, and is tried again",
          "[common][voxel][pyramid]") {
    SyntheticWorld world(kBounds);
    world.fails_at_bx = 1;
    CHECK_THROWS_AS(world.box({0, 1, 0, 3}), util::Error);
    CHECK_THROWS_AS(world.box({2, 0, 0, 0}), util::Error);
    CHECK_NOTHROW(world.box({0, 0, 0, 3}));
    world.fails_at_bx = 1 << 20;
    CHECK(world.box({0, 1, 0, 3}) != nullptr);
    CHECK(world.box({2, 0, 0, 0}) != nullptr);
}
