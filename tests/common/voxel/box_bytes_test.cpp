#include <bit>

#include "common/voxel/box_builder.hpp"
#include "tests/catch.hpp"
#include "tests/common/voxel/scene.hpp"

using namespace terravox::voxel;
using terravox::test::random_scene;
using terravox::test::Scene;
using terravox::test::to_attr;

namespace {

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

}  // namespace

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

TEST_CASE("a voxel alone has that form wherever it lies", "[common][voxel][box]") {
    std::mt19937 random(7);
    for (int i = 0; i < 30; ++i) {
        const int x = static_cast<int>(random() % 64);
        const int y = static_cast<int>(random() % 256);
        const int z = static_cast<int>(random() % 64);
        Scene scene;
        scene.add(x, z, y, y + 1, i % 2 == 0);
        INFO("at (" << x << ", " << y << ", " << z << ")");
        CHECK(same_bytes(scene));
    }
}
