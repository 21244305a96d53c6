// What a camera shows of a survey in which something flies, or lies, far from all else.
#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/world/cloud.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

/// 80 x 80 m of level land.
Cloud plain() {
    Cloud out;
    out.cover(0, 0, 80, 80, 0.8, 2, [](double, double) { return 100.5; });
    return out;
}

/// A plain, and one 200 m above it.
Cloud cliff() {
    Cloud out;
    out.cover(0, 0, 80, 80, 0.8, 2, [](double e, double) { return e < 40 ? 100.5 : 300.5; });
    return out;
}

}  // namespace

TEST_CASE("a camera shows a survey without the points that lie far from nearly all others",
          "[voxelserver][voxelize]") {
    struct Case {
        const char* name;
        Cloud cloud;
        double stray;
        std::optional<std::int32_t> bottom;  // nullopt: that of the world
        std::optional<std::int32_t> top;
    };
    // From 98 % of the heights up and from 2 % down, 30 m or a quarter of what lies between; land
    // is solid for 10 m below its lowest points, and those lie at most 50 m below 2 %.
    const auto c = GENERATE(values<Case>({
        {"a mast on a plain", plain(), 129.5, {}, {}},
        {"a bird over a plain", plain(), 500.5, {}, 131},
        {"a well in a plain", plain(), 60.5, {}, {}},
        {"an echo below a plain", plain(), -200.5, 100 - 50 - 10, {}},
        {"a mast on a cliff", cliff(), 340.5, {}, {}},
        {"a bird over a cliff", cliff(), 700.5, {}, 351},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        c.cloud.write(folder.path() / "clean.las");
        Cloud with_stray = c.cloud;
        with_stray.add(40.2, 40.2, c.stray, 1);
        with_stray.write(folder.path() / "stray.las");
        const OpenWorld clean(folder.path() / "clean.las");
        const OpenWorld stray(folder.path() / "stray.las");
        CHECK(clean.info().camera_bounds() == clean.info().bounds);
        const voxel::VoxelBounds all = stray.info().bounds;
        const auto at = static_cast<std::int32_t>(std::floor(c.stray));
        CHECK(all.min[1] <= at);
        CHECK(all.max[1] > at);
        const voxel::VoxelBounds shown = stray.info().camera_bounds();
        CHECK(shown.min[1] == c.bottom.value_or(all.min[1]));
        CHECK(shown.max[1] == c.top.value_or(all.max[1]));
        for (const std::size_t axis : {0U, 2U}) {
            CHECK(shown.min[axis] == all.min[axis]);
            CHECK(shown.max[axis] == all.max[axis]);
        }
        CHECK(stray.info().typical_heights.has_value() == (c.bottom || c.top));
    }
}

// Files are written flight line by flight line, and the first points of a compressed file with one
// or two chunks lie together: what they do not meet may be another valley.
TEST_CASE("a camera shows all of a survey whose sampled points lie in a part of it",
          "[voxelserver][voxelize]") {
    const TemporaryFolder folder;
    Cloud cloud;
    cloud.cover(0, 0, 80, 80, 0.5, 2, [](double, double n) { return n < 40 ? 200.5 : 100.5; });
    cloud.write(folder.path() / "valley.laz");
    CHECK_FALSE(OpenWorld(folder.path() / "valley.laz").info().typical_heights.has_value());
    cloud.add(40.2, 40.2, 700.5, 1);
    cloud.write(folder.path() / "bird.laz");
    const OpenWorld bird(folder.path() / "bird.laz");
    CHECK(bird.info().camera_bounds().max[1] == 231);
    CHECK(bird.info().camera_bounds().min[1] == bird.info().bounds.min[1]);
}
