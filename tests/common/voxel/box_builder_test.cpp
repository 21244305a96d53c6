#include <algorithm>
#include <array>
#include <map>
#include <random>
#include <tuple>

#include "common/voxel/box.hpp"
#include "common/voxel/box_builder.hpp"
#include "tests/catch.hpp"
#include "tests/common/voxel/scene.hpp"

using namespace terravox::voxel;
using terravox::test::random_scene;
using terravox::test::Scene;
using terravox::test::to_attr;
using terravox::voxel::ColumnBits;

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

constexpr BoxKey kBytesKey{0, 5, -2, 9};

// A cube of 4^n voxels, one voxel at a time.
struct Cube {
    bool any = false;
    bool all_hidden = true;
};

// The format as docs/formats/box.md describes it, from a plain array of voxels: slow, and shares
// nothing with the builder.
struct PlainTree {
    const Scene& scene;
    std::vector<TreeCell> roots;
    std::vector<TreeCell> middles;
    std::vector<TreeCell> bricks;
    std::vector<VoxelAttr> attrs;

    [[nodiscard]] Cube look(int x, int y, int z, int side) const {
        Cube cube;
        for (int i = 0; i < side * side * side; ++i) {
            const int vx = x + i % side;
            const int vz = z + i / side % side;
            const int vy = y + i / side / side;
            cube.any = cube.any || scene.solid(vx, vy, vz);
            cube.all_hidden =
                cube.all_hidden && scene.solid(vx, vy, vz) && !scene.visible(vx, vy, vz);
        }
        return cube;
    }
    TreeCell cell(int x, int y, int z, int side) {
        TreeCell out;
        const int step = side / 4;
        auto& below = step == 16 ? middles : bricks;
        out.first = static_cast<std::uint32_t>(step == 1 ? attrs.size() : below.size());
        std::vector<TreeCell> children;
        for (int bit = 0; bit < 64; ++bit) {
            const int cx = x + bit % 4 * step;
            const int cz = z + bit / 4 % 4 * step;
            const int cy = y + bit / 16 * step;
            const Cube cube = look(cx, cy, cz, step);
            if (!cube.any)
                continue;
            out.mask |= std::uint64_t{1} << bit;
            if (cube.all_hidden)
                continue;
            out.detail |= std::uint64_t{1} << bit;
            if (step == 1)
                attrs.push_back(to_attr(cx, cy, cz));
            else
                below.push_back(cell(cx, cy, cz, step));
        }
        return out;
    }
    std::shared_ptr<const Box> box() {
        bool any = false;
        for (int root = 0; root < Box::kRootCount; ++root) {
            roots.push_back(cell(0, root * 64, 0, 64));
            any = any || roots.back().mask != 0;
        }
        if (!any)
            return nullptr;
        std::vector<TreeCell> cells = roots;
        for (TreeCell& cell : cells)
            cell.first += Box::kRootCount;
        for (TreeCell middle : middles) {
            middle.first += static_cast<std::uint32_t>(Box::kRootCount + middles.size());
            cells.push_back(middle);
        }
        cells.insert(cells.end(), bricks.begin(), bricks.end());
        return Box::from_arrays(kBytesKey, cells, attrs);
    }
};

bool same_bytes(const Scene& scene) {
    const auto built = scene.build(kBytesKey, to_attr);
    const auto plain = PlainTree{scene, {}, {}, {}, {}}.box();
    if (!built || !plain)
        return built == plain;
    return std::equal(built->blob().begin(), built->blob().end(), plain->blob().begin(),
                      plain->blob().end());
}

Scene make_run_scene(std::vector<std::array<int, 2>> runs, bool opaque) {
    Scene scene;
    for (int z = -1; z < 65; ++z)
        for (int x = -1; x < 65; ++x)
            for (const auto& run : runs)
                scene.add(x, z, run[0], run[1], opaque);
    return scene;
}

// One flag for each y in [-1, 257).
struct PlainColumn {
    std::array<bool, 258> at{};
    void fill(int y0, int y1) {
        for (int y = std::max(y0, -1); y < std::min(y1, 257); ++y)
            at[static_cast<std::size_t>(y + 1)] = true;
    }
    [[nodiscard]] bool get(int y) const { return at[static_cast<std::size_t>(y + 1)]; }
};

void check_equal(const ColumnBits& bits, const PlainColumn& plain) {
    int wrong = 0;
    for (int y = -1; y < 257; ++y)
        wrong += bits.at(y) != plain.get(y);
    for (int y = 0; y < 256; ++y) {
        wrong += (bits.word(y / 64) >> (y % 64) & 1) != static_cast<unsigned>(plain.get(y));
        wrong += (bits.word_from_above(y / 64) >> (y % 64) & 1) !=
                 static_cast<unsigned>(plain.get(y + 1));
        wrong += (bits.word_from_below(y / 64) >> (y % 64) & 1) !=
                 static_cast<unsigned>(plain.get(y - 1));
    }
    CHECK(wrong == 0);
}

// Bit by bit, as the definition says.
std::uint64_t by_definition(std::int32_t x, std::int32_t y, std::int32_t z) {
    std::uint64_t code = 0;
    for (unsigned bit = 0; bit < 21; ++bit) {
        code |= std::uint64_t{static_cast<std::uint32_t>(x) >> bit & 1} << (3 * bit);
        code |= std::uint64_t{static_cast<std::uint32_t>(y) >> bit & 1} << (3 * bit + 1);
        code |= std::uint64_t{static_cast<std::uint32_t>(z) >> bit & 1} << (3 * bit + 2);
    }
    return code;
}

void check_all_ways(std::int32_t x, std::int32_t y, std::int32_t z) {
    INFO("(" << x << ", " << y << ", " << z << ")");
    const std::uint64_t code = morton_encode(x, y, z);
    CHECK(code == by_definition(x, y, z));
    CHECK(code == morton_encode_portable(x, y, z));
    const MortonCoord back = morton_decode(code);
    CHECK((back.x == x && back.y == y && back.z == z));
}

constexpr std::int32_t kLowest = -(1 << 20);
constexpr std::int32_t kHighest = (1 << 20) - 1;

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

TEST_CASE("a built box has, byte for byte, the format's one form of its voxels",
          "[common][voxel][box]") {
    const auto seed = GENERATE(range(std::uint64_t{1}, std::uint64_t{9}));
    INFO("seed " << seed);
    CHECK(same_bytes(random_scene(seed)));
}

TEST_CASE("whole storeys, bricks and layers of rock or air have that form too",
          "[common][voxel][box]") {
    struct Case {
        const char* name;
        std::vector<std::array<int, 2>> runs;
        bool opaque;
    };
    const auto c = GENERATE(values<Case>({
        {"air", {}, true},
        {"rock throughout", {{-1, 257}}, true},
        {"water throughout", {{-1, 257}}, false},
        {"rock up to a storey", {{-1, 64}}, true},
        {"rock up to a brick", {{-1, 68}}, true},
        {"rock up to a middle cell", {{-1, 80}}, true},
        {"a layer at the bottom", {{0, 1}}, true},
        {"a layer at the top", {{255, 256}}, true},
        {"only the margins", {{-1, 0}, {256, 257}}, true},
        {"a gap of a storey", {{-1, 64}, {128, 257}}, true},
        {"a layer in every storey", {{3, 4}, {67, 70}, {130, 131}, {195, 200}}, true},
    }));
    DYNAMIC_SECTION(c.name) {
        CHECK(same_bytes(make_run_scene(c.runs, c.opaque)));
    }
}

TEST_CASE("random runs add up in a column", "[common][voxel][column]") {
    const auto seed = GENERATE(range(0u, 200u));
    std::mt19937 random(seed);
    ColumnBits bits;
    PlainColumn plain;
    // Of none to eleven runs many are turned round, or end beyond the column or its margins.
    const auto runs = seed < 50 ? 1 : random() % 12;
    for (unsigned i = 0; i < runs; ++i) {
        const int y0 = static_cast<int>(random() % 280) - 12;
        const int y1 = i % 4 == 3 ? 100'000 : y0 - 20 + static_cast<int>(random() % 100);
        bits.fill(y0, y1);
        plain.fill(y0, y1);
    }
    INFO("seed " << seed);
    check_equal(bits, plain);
}

TEST_CASE("a Morton code interleaves x, y, z from the lowest bit on, and leads back to them",
          "[common][voxel][morton]") {
    for (const std::int32_t x : {kLowest, -1, 0, 1, kHighest})
        for (const std::int32_t y : {kLowest, -1, 0, 1, kHighest})
            for (const std::int32_t z : {kLowest, -1, 0, 1, kHighest})
                check_all_ways(x, y, z);
}

TEST_CASE("random coordinates go to a Morton code and back, with and without BMI2",
          "[common][voxel][morton]") {
    std::mt19937 random(20240621);
    std::uniform_int_distribution<std::int32_t> any(kLowest, kHighest);
    for (int i = 0; i < 2000; ++i)
        check_all_ways(any(random), any(random), any(random));
}

TEST_CASE("coordinates beyond the range are taken modulo 2^21, the same either way",
          "[common][voxel][morton]") {
    std::mt19937 random(7);
    for (int i = 0; i < 2000; ++i) {
        const auto x = static_cast<std::int32_t>(random());
        const auto y = static_cast<std::int32_t>(random());
        const auto z = static_cast<std::int32_t>(random());
        INFO("(" << x << ", " << y << ", " << z << ")");
        CHECK(morton_encode(x, y, z) == by_definition(x, y, z));
        CHECK(morton_encode_portable(x, y, z) == by_definition(x, y, z));
    }
}
