#include "common/voxel/downsample.hpp"

#include <cmath>
#include <map>
#include <random>

#include "tests/catch.hpp"
#include "tests/common/voxel/scene.hpp"

using namespace terravox::voxel;
using terravox::test::Scene;

namespace {

using Children = std::array<std::shared_ptr<const Box>, 8>;
constexpr BoxKey kFine{0, 0, 0, 0}, kCoarse{1, 0, 0, 0};

// A voxel by coordinates in the 128 x 512 x 128 voxels of all eight children.
std::optional<VoxelAttr> fine_voxel(const Children& children, int x, int y, int z) {
    const auto& box = children[static_cast<std::size_t>(x / 64 + 2 * (z / 64) + 4 * (y / 256))];
    return box ? box->voxel(x % 64, y % 256, z % 64) : std::nullopt;
}

// The rule of the header, spelled out: the most frequent material among the visible children (a tie goes to the highest),
// attributes of the highest child of that material, and the rounded mean of its colours.
VoxelAttr expected_attr(const Children& children, int x, int y, int z) {
    struct Votes { int count = 0; int height = -1; VoxelAttr first; int r = 0, g = 0, b = 0, coloured = 0; };
    std::vector<Votes> votes;
    for (const int dy : {1, 0})
        for (int i = 0; i < 4; ++i) {
            const auto voxel = fine_voxel(children, 2 * x + i % 2, 2 * y + dy, 2 * z + i / 2);
            if (!voxel || *voxel == VoxelAttr{}) continue;
            auto at = std::find_if(votes.begin(), votes.end(), [&](const Votes& v) { return v.first.material == voxel->material; });
            if (at == votes.end()) at = votes.insert(at, Votes{0, dy, *voxel, 0, 0, 0, 0});
            ++at->count;
            if (voxel->has_colour()) at->r += voxel->colour.r, at->g += voxel->colour.g, at->b += voxel->colour.b, ++at->coloured;
        }
    if (votes.empty()) return {};
    const auto best = *std::max_element(votes.begin(), votes.end(), [](const Votes& a, const Votes& b) {
        return a.count != b.count ? a.count < b.count : a.height < b.height;
    });
    VoxelAttr out = best.first;
    if (best.coloured > 0) {
        const auto mean = [&](int sum) { return static_cast<std::uint8_t>(std::floor(static_cast<double>(sum) / best.coloured + 0.5)); };
        out.colour = {mean(best.r), mean(best.g), mean(best.b)};
        out.flags |= VoxelAttr::kHasColour;
    }
    return out;
}

Scene expected_scene(const Children& children) {
    Scene scene;
    for (int z = 0; z < 64; ++z)
        for (int x = 0; x < 64; ++x)
            for (int y = 0; y < 256; ++y) {
                int solid = 0, opaque = 0;
                for (int i = 0; i < 8; ++i)
                    if (const auto v = fine_voxel(children, 2 * x + i % 2, 2 * y + i / 4, 2 * z + i / 2 % 2)) ++solid, opaque += !see_through(v->material);
                if (solid >= 4) scene.add(x, z, y, y + 1, 2 * opaque > solid);
            }
    return scene;
}

// Few materials and colours on some voxels only, so that votes, ties and missing colours all happen.
VoxelAttr random_attr(int x, int y, int z) {
    std::mt19937 random(static_cast<unsigned>(x + 64 * y + 64 * 256 * z));
    constexpr std::array kMaterials = {Material::kGround, Material::kGrass, Material::kRoof, Material::kWater, Material::kRock};
    VoxelAttr attr;
    attr.material = kMaterials[random() % kMaterials.size()];
    attr.source_class = static_cast<std::uint8_t>(random());
    if (random() % 3 != 0) attr.flags = VoxelAttr::kHasColour, attr.colour = {static_cast<std::uint8_t>(random()), static_cast<std::uint8_t>(random()), 9};
    return attr;
}

VoxelAttr ground(int, int, int) { return {.material = Material::kGround, .colour = {}}; }

std::size_t solid_in(const Box& box) {
    std::size_t count = 0;
    for (int y = 0; y < kBoxSizeY; ++y)
        for (int z = 0; z < kBoxSizeZ; ++z)
            for (int x = 0; x < kBoxSizeX; ++x) count += box.solid(x, y, z);
    return count;
}

Children alone(std::shared_ptr<const Box> box, std::size_t slot = 0) {
    Children children;
    children[slot] = std::move(box);
    return children;
}

}  // namespace

TEST_CASE("a coarse box is what the rule makes of its eight children", "[common][voxel][downsample]") {
    const auto seed = GENERATE(1, 2, 3);
    INFO("seed " << seed);
    Children children;
    for (std::size_t i = 0; i < 8; ++i)
        if (static_cast<int>(i) != 3 * seed - 2) children[i] = terravox::test::random_scene(static_cast<std::uint64_t>(seed) * 8 + i).build(kFine, random_attr);
    const auto coarse = downsample(kCoarse, children);
    REQUIRE(coarse);
    CHECK(coarse->key() == kCoarse);
    const Scene expected = expected_scene(children);
    CHECK(coarse->top() == expected.top());
    int wrong = 0;
    for (int y = 0; y < 256; ++y)
        for (int z = 0; z < 64; ++z)
            for (int x = 0; x < 64; ++x) {
                const auto found = coarse->voxel(x, y, z);
                const auto rule = !expected.solid(x, y, z)    ? std::nullopt
                                  : expected.visible(x, y, z) ? std::optional(expected_attr(children, x, y, z))
                                                              : std::optional(VoxelAttr{});
                if (found == rule) continue;
                if (++wrong <= 3) UNSCOPED_INFO("differs at (" << x << ", " << y << ", " << z << ")");
            }
    CHECK(wrong == 0);
}

TEST_CASE("eight empty children make no box, and so do too few voxels", "[common][voxel][downsample]") {
    CHECK(downsample(kCoarse, {}) == nullptr);
    Scene speck;
    speck.add(10, 10, 4, 6, true), speck.add(11, 10, 4, 5, true);  // three of eight
    CHECK(downsample(kCoarse, alone(speck.build(kFine, ground))) == nullptr);
    speck.add(11, 10, 5, 6, true);
    CHECK(downsample(kCoarse, alone(speck.build(kFine, ground))) != nullptr);
}

TEST_CASE("each child lands in its own octant", "[common][voxel][downsample]") {
    const auto slot = GENERATE(range(std::size_t{0}, std::size_t{8}));
    Scene cube;
    for (int i = 0; i < 4; ++i) cube.add(6 + i % 2, 8 + i / 2, 10, 12, true);
    const auto coarse = downsample(kCoarse, alone(cube.build(kFine, ground), slot));
    INFO("slot " << slot);
    REQUIRE(coarse);
    CHECK(solid_in(*coarse) == 1);
    CHECK(coarse->solid(3 + 32 * static_cast<int>(slot & 1), 5 + 128 * static_cast<int>(slot >> 2), 4 + 32 * static_cast<int>(slot >> 1 & 1)));
}

TEST_CASE("a sheet one voxel thick survives every level", "[common][voxel][downsample]") {
    struct Case { const char* name; int roof_y; int wall_x; };
    const auto c = GENERATE(values<Case>({
        {"a roof at an even height", 36, -1}, {"a roof at an odd height", 37, -1}, {"a roof at the top of the box", 255, -1},
        {"a wall at an even place", -1, 20}, {"a wall at an odd place", -1, 21}, {"a wall at the edge of the box", -1, 63},
    }));
    DYNAMIC_SECTION(c.name) {
        Scene scene;
        for (int z = 0; z < 64; ++z)
            for (int x = 0; x < 64; ++x)
                if (c.wall_x < 0) scene.add(x, z, c.roof_y, c.roof_y + 1, true);
                else if (x == c.wall_x) scene.add(x, z, 0, 256, true);
        auto box = scene.build(kFine, ground);
        for (int level = 1; level <= 6; ++level) {
            box = downsample({level, 0, 0, 0}, alone(box));
            INFO("level " << level);
            REQUIRE(box);
            const std::size_t side = std::size_t{64} >> level;
            CHECK(solid_in(*box) == side * (c.wall_x < 0 ? side : std::size_t{256} >> level));
        }
    }
}

TEST_CASE("ground keeps its height on average", "[common][voxel][downsample]") {
    const auto seed = GENERATE(1u, 2u, 3u);
    std::mt19937 random(seed);
    Scene scene;
    const double slope_x = (random() % 100) / 100.0, slope_z = (random() % 100) / 100.0;
    double fine_mean = 0;
    for (int z = 0; z < 64; ++z)
        for (int x = 0; x < 64; ++x) {
            const int height = 20 + static_cast<int>(slope_x * x + slope_z * z) + static_cast<int>(random() % 3);
            scene.add(x, z, 0, height, true);
            fine_mean += height / 4096.0;
        }
    const auto coarse = downsample(kCoarse, alone(scene.build(kFine, ground)));
    INFO("seed " << seed);
    REQUIRE(coarse);
    double coarse_mean = 0;
    for (int z = 0; z < 32; ++z)
        for (int x = 0; x < 32; ++x) {
            int height = 256;
            while (height > 0 && !coarse->solid(x, height - 1, z)) --height;
            coarse_mean += height / 1024.0;
        }
    // Half full counts as full, which lifts a quarter-step mean by an eighth of a fine voxel; the rest is chance.
    CHECK(std::abs(2 * coarse_mean - fine_mean) < 0.25);
}
