#include "common/voxel/box_builder.hpp"

#include <map>
#include <tuple>

#include "tests/catch.hpp"
#include "tests/common/voxel/scene.hpp"

using namespace terravox::voxel;
using terravox::test::random_scene;
using terravox::test::Scene;
using terravox::test::to_attr;

namespace {

constexpr BoxKey kBuiltKey{0, -3, 1, 7};

// The first voxel where the box and the scene differ, as text; empty when there is none.
std::string first_difference(const Box& box, const Scene& scene) {
    for (int y = 0; y < kBoxSizeY; ++y)
        for (int z = 0; z < kBoxSizeZ; ++z)
            for (int x = 0; x < kBoxSizeX; ++x) {
                const auto found = box.voxel(x, y, z);
                const auto expected = !scene.solid(x, y, z)    ? std::nullopt
                                      : scene.visible(x, y, z) ? std::optional(to_attr(x, y, z))
                                                               : std::optional(VoxelAttr{});
                if (found != expected || box.solid(x, y, z) != scene.solid(x, y, z))
                    return "(" + std::to_string(x) + ", " + std::to_string(y) + ", " +
                           std::to_string(z) + ")";
            }
    return "";
}

Scene filled_with(int y0, int y1, int x0 = -1, int x1 = 65, int z0 = -1, int z1 = 65) {
    Scene scene;
    for (int z = z0; z < z1; ++z)
        for (int x = x0; x < x1; ++x)
            scene.add(x, z, y0, y1, true);
    return scene;
}

std::size_t attrs_in(const Scene& scene) {
    return scene.build(kBuiltKey, to_attr)->attrs().size();
}

}  // namespace

TEST_CASE("a box holds what a plain array of voxels holds", "[common][voxel][box]") {
    const auto seed = GENERATE(range(std::uint64_t{1}, std::uint64_t{13}));
    INFO("seed " << seed);
    const Scene scene = random_scene(seed);
    const auto box = scene.build(kBuiltKey, to_attr);
    REQUIRE(box);
    CHECK(first_difference(*box, scene) == "");
    CHECK(box->top() == scene.top());
    CHECK(box->key() == kBuiltKey);
}

TEST_CASE("attributes are requested once for each visible voxel, and for no other",
          "[common][voxel][box]") {
    const Scene scene = random_scene(99);
    std::map<std::tuple<int, int, int>, int> requests;
    const auto box = scene.build(
        kBuiltKey, [&](int x, int y, int z) { return ++requests[{x, y, z}], to_attr(x, y, z); });
    int wrong = 0;
    int visible = 0;
    for (int y = 0; y < kBoxSizeY; ++y)
        for (int z = 0; z < kBoxSizeZ; ++z)
            for (int x = 0; x < kBoxSizeX; ++x)
                visible += scene.visible(x, y, z);
    for (const auto& [at, times] : requests)
        wrong += times != 1 || !scene.visible(std::get<0>(at), std::get<1>(at), std::get<2>(at));
    CHECK(wrong == 0);
    CHECK(requests.size() == static_cast<std::size_t>(visible));
    CHECK(box->attrs().size() == static_cast<std::size_t>(visible));
}

TEST_CASE("a box without anything solid is no box", "[common][voxel][box]") {
    CHECK(Scene().build(kBuiltKey, to_attr) == nullptr);
    Scene margins_only;
    for (int i = -1; i < 65; ++i) {
        margins_only.add(i, -1, -1, 257, true);
        margins_only.add(64, i, -1, 257, true);
    }
    margins_only.add(5, 5, -1, 0, true);
    margins_only.add(5, 5, 256, 257, true);
    CHECK(margins_only.build(kBuiltKey, to_attr) == nullptr);
}

TEST_CASE("a box deep inside rock has only its four roots", "[common][voxel][box]") {
    const auto box = filled_with(-1, 257).build(kBuiltKey, to_attr);
    REQUIRE(box);
    CHECK(box->cells().size() == Box::kRootCount);
    CHECK(box->attrs().empty());
    for (const TreeCell& root : box->cells())
        CHECK((root.mask == ~std::uint64_t{0} && root.detail == 0));
    CHECK(box->voxel(0, 0, 0) == VoxelAttr{});
    CHECK(box->voxel(63, 255, 63) == VoxelAttr{});
    CHECK(box->top() == 256);
}

TEST_CASE("the margin decides which faces at the box's edge can be seen", "[common][voxel][box]") {
    struct Case {
        const char* name;
        Scene scene;
        std::size_t attrs;
    };
    const auto c = GENERATE(values<Case>({
        {"rock on all sides", filled_with(-1, 257), 0},
        {"air above", filled_with(-1, 256), 64 * 64},
        {"air below", filled_with(0, 257), 64 * 64},
        {"air to the west", filled_with(-1, 257, 0), 256 * 64},
        {"air to the east", filled_with(-1, 257, -1, 64), 256 * 64},
        {"air to the north", filled_with(-1, 257, -1, 65, 0), 256 * 64},
        {"air to the south", filled_with(-1, 257, -1, 65, -1, 64), 256 * 64},
        {"air all around", filled_with(0, 256, 0, 64, 0, 64), 64 * 64 * 256 - 62 * 62 * 254},
    }));
    DYNAMIC_SECTION(c.name) {
        CHECK(attrs_in(c.scene) == c.attrs);
    }
}

TEST_CASE("rock behind water and leaves keeps its attributes", "[common][voxel][box]") {
    Scene lake = filled_with(-1, 100);
    for (int z = -1; z < 65; ++z)
        for (int x = -1; x < 65; ++x)
            lake.add(x, z, 100, 110, false);
    const auto box = lake.build(kBuiltKey, to_attr);
    CHECK(box->attrs().size() == 64 * 64 * 11);
    CHECK(box->voxel(3, 99, 4) == to_attr(3, 99, 4));
    CHECK(box->voxel(3, 98, 4) == VoxelAttr{});
}

TEST_CASE("the top of a box is one past its highest voxel", "[common][voxel][box]") {
    struct Case {
        const char* name;
        int x;
        int y;
        int z;
    };
    const auto c = GENERATE(values<Case>({
        {"bottom corner", 0, 0, 0},
        {"one brick up", 63, 4, 0},
        {"below a 16-cell's edge", 17, 15, 40},
        {"above it", 17, 16, 40},
        {"below a root's edge", 30, 63, 63},
        {"above it", 30, 64, 63},
        {"the very top", 63, 255, 63},
    }));
    DYNAMIC_SECTION(c.name) {
        Scene scene;
        scene.add(c.x, c.z, c.y, c.y + 1, true);
        scene.add(1, 1, 0, std::min(c.y + 1, 2), false);  // a lower voxel elsewhere
        CHECK(scene.build(kBuiltKey, to_attr)->top() == c.y + 1);
    }
}

TEST_CASE("the order of columns does not change a box's bytes", "[common][voxel][box]") {
    BoxBuilder forward;
    BoxBuilder backward;
    for (int i = 0; i < 64; ++i)
        forward.add(i, 63 - i, i, 2 * i + 3, i % 2 == 0);
    for (int i = 63; i >= 0; --i)
        backward.add(i, 63 - i, i, 2 * i + 3, i % 2 == 0);
    const auto a = forward.build(kBuiltKey, to_attr);
    const auto b = backward.build(kBuiltKey, to_attr);
    CHECK(std::equal(a->blob().begin(), a->blob().end(), b->blob().begin(), b->blob().end()));
    CHECK(a->checksum() == b->checksum());
}

TEST_CASE("a box is named level/bx/by/bz", "[common][voxel][box]") {
    CHECK(to_string(BoxKey{4, -1, 0, 12}) == "4/-1/0/12");
}
