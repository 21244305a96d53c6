#include "common/voxel/box_builder.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "common/voxel/coarse_rule.hpp"
#include "tests/catch.hpp"
#include "tests/common/voxel/material_grid.hpp"
#include "tests/common/voxel/scene.hpp"

using namespace terravox::voxel;
using terravox::test::alone;
using terravox::test::Scene;

namespace {

using Children = std::array<std::shared_ptr<const Box>, 8>;
constexpr BoxKey kFine{0, 0, 0, 0};
constexpr BoxKey kCoarse{1, 0, 0, 0};

// A voxel by coordinates in the 128 x 512 x 128 voxels of all eight children.
std::optional<VoxelAttr> fine_voxel(const Children& children, int x, int y, int z) {
    const auto& box = children[static_cast<std::size_t>(x / 64 + 2 * (z / 64) + 4 * (y / 256))];
    return box ? box->voxel(x % 64, y % 256, z % 64) : std::nullopt;
}

using Eight = std::array<std::optional<VoxelAttr>, 8>;  // index = dx + 2 dz + 4 dy
int find_column(std::size_t i) {
    return static_cast<int>(i % 4);
}

// The rule of coarse_rule.hpp, one voxel at a time: which children decide; empty for air.
std::vector<std::size_t> deciding(const Eight& children, int level) {
    const auto is = [&](std::size_t i, Grain grain) {
        return children[i] && to_grain(children[i]->material) == grain;
    };
    const auto opaque = [&](std::size_t i) {
        return is(i, Grain::kTerrain) || is(i, Grain::kShell) || is(i, Grain::kObject);
    };
    const auto overhang = [&](std::size_t i) {
        return i >= 4 && is(i, Grain::kTerrain) && !opaque(i - 4);
    };
    std::vector<std::size_t> all_opaque;
    std::vector<std::size_t> thin;
    std::vector<std::size_t> water;
    std::vector<std::size_t> sparse;
    std::size_t objects = 0;
    std::array<bool, 4> built{};
    std::array<bool, 4> leafy{};
    bool kept = false;
    for (std::size_t i = 0; i < 8; ++i) {
        if (opaque(i))
            all_opaque.push_back(i);
        if (opaque(i) && (!is(i, Grain::kTerrain) || overhang(i)))
            thin.push_back(i);
        if (is(i, Grain::kWater))
            water.push_back(i);
        if (is(i, Grain::kSparse))
            sparse.push_back(i);
        objects += is(i, Grain::kObject);
        if (is(i, Grain::kShell) || is(i, Grain::kObject))
            built[static_cast<std::size_t>(find_column(i))] = true;
        kept = kept || overhang(i) || (level <= 2 && is(i, Grain::kShell));
    }
    const auto area_kept = [](const std::array<bool, 4>& column) {
        return column[0] || (column[1] && column[2] && column[3]);
    };
    kept = kept || (level <= 2 ? objects >= 2 || is(0, Grain::kObject) || is(4, Grain::kObject)
                               : area_kept(built));
    if (kept)
        return all_opaque.size() >= 4 ? all_opaque : thin;
    if (all_opaque.size() + water.size() >= 4) {
        int lead = 0;
        bool key_is_water = false;
        for (std::size_t c = 0; c < 4; ++c)
            for (const std::size_t i : {c + 4, c}) {
                if (!opaque(i) && !is(i, Grain::kWater))
                    continue;
                lead += opaque(i) ? -1 : 1;
                if (c == 0)
                    key_is_water = !opaque(i);
                break;
            }
        return lead > 0 || (lead == 0 && key_is_water) ? water : all_opaque;
    }
    for (const std::size_t i : sparse)
        leafy[static_cast<std::size_t>(find_column(i))] = true;
    return area_kept(leafy) ? sparse : std::vector<std::size_t>{};
}

// The most frequent material among the topmost children of each column (a tie goes to the highest),
// attributes of the first child of that material, the rounded mean of its colours.
VoxelAttr expected_attr(const Eight& children, const std::vector<std::size_t>& deciders) {
    std::vector<VoxelAttr> voters;
    std::array<bool, 4> voted{};
    for (const bool upper : {true, false})
        for (const std::size_t i : deciders) {
            auto& column = voted[static_cast<std::size_t>(find_column(i))];
            if ((i >= 4) != upper || column || *children[i] == VoxelAttr{})
                continue;
            column = true;
            voters.push_back(*children[i]);
        }
    if (voters.empty())
        return {};
    const auto votes = [&](const VoxelAttr& of) {
        return std::count_if(voters.begin(), voters.end(),
                             [&](const auto& v) { return v.material == of.material; });
    };
    VoxelAttr out =
        *std::max_element(voters.begin(), voters.end(),
                          [&](const auto& a, const auto& b) { return votes(a) < votes(b); });
    double r = 0;
    double g = 0;
    double b = 0;
    double coloured = 0;
    for (const auto& v : voters)
        if (v.material == out.material && v.has_colour()) {
            r += v.colour.r;
            g += v.colour.g;
            b += v.colour.b;
            ++coloured;
        }
    if (coloured > 0) {
        const auto mean = [&](double sum) {
            return static_cast<std::uint8_t>(std::floor(sum / coloured + 0.5));
        };
        out.colour = {mean(r), mean(g), mean(b)};
        out.flags |= VoxelAttr::kHasColour;
    }
    return out;
}

std::optional<VoxelAttr> expected_voxel(const Children& children, int level, int x, int y, int z) {
    Eight eight;
    for (int i = 0; i < 8; ++i)
        eight[static_cast<std::size_t>(i)] =
            fine_voxel(children, 2 * x + i % 2, 2 * y + i / 4, 2 * z + i / 2 % 2);
    const auto deciders = deciding(eight, level);
    return deciders.empty() ? std::nullopt : std::optional(expected_attr(eight, deciders));
}

// Few materials and colours on some voxels only, so that votes, ties and missing colours all
// happen.
VoxelAttr random_attr(int x, int y, int z) {
    std::mt19937 random(static_cast<unsigned>(x + 64 * y + 64 * 256 * z));
    using enum Material;
    constexpr std::array kOften = {kGround, kGrass, kWater, kRock, kHighVegetation, kLowVegetation};
    constexpr std::array kRare = {kRoof, kWall, kObject, kWire, static_cast<Material>(200), kAir};
    VoxelAttr attr;
    attr.material =
        random() % 16 == 0 ? kRare[random() % kRare.size()] : kOften[random() % kOften.size()];
    attr.source_class =
        static_cast<std::uint8_t>(random() | 1);  // a hidden voxel is the one with 0
    if (random() % 3 != 0) {
        attr.flags = VoxelAttr::kHasColour;
        attr.colour = {static_cast<std::uint8_t>(random()), static_cast<std::uint8_t>(random()), 9};
    }
    return attr;
}

VoxelAttr ground(int, int, int) {
    return {.material = Material::kGround, .colour = {}};
}

std::size_t solid_in(const Box& box) {
    std::size_t count = 0;
    for (int y = 0; y < kBoxSizeY; ++y)
        for (int z = 0; z < kBoxSizeZ; ++z)
            for (int x = 0; x < kBoxSizeX; ++x)
                count += box.solid(x, y, z);
    return count;
}

}  // namespace

TEST_CASE("a coarse box is what the rule makes of its eight children",
          "[common][voxel][downsample]") {
    // Levels have one rule up to the second, and another from the third on.
    const auto [seed, level] = GENERATE(table<int, int>({{1, 2}, {2, 3}, {3, 2}}));
    INFO("seed " << seed << ", level " << level);
    Children children;
    for (std::size_t i = 0; i < 8; ++i)
        if (static_cast<int>(i) != 3 * seed - 2)
            children[i] = terravox::test::random_scene(static_cast<std::uint64_t>(seed) * 8 + i)
                              .build(kFine, random_attr);
    const BoxKey key{level, 3, -1, 2};
    const auto coarse = downsample(key, children);
    REQUIRE(coarse);
    CHECK(coarse->key() == key);
    int wrong = 0;
    int solid = 0;
    for (int y = 0; y < 256; ++y)
        for (int z = 0; z < 64; ++z)
            for (int x = 0; x < 64; ++x) {
                const auto found = coarse->voxel(x, y, z);
                solid += found.has_value();
                if (found == expected_voxel(children, level, x, y, z))
                    continue;
                if (++wrong <= 3)
                    UNSCOPED_INFO("differs at (" << x << ", " << y << ", " << z << ")");
            }
    CHECK(wrong == 0);
    CHECK(solid > 10'000);
    CHECK(Box::from_blob(coarse->blob(), "the coarse box")->checksum() ==
          coarse->checksum());  // its indices lead nowhere else
}

TEST_CASE("eight empty children make no box, and so do too few voxels",
          "[common][voxel][downsample]") {
    CHECK(downsample(kCoarse, {}) == nullptr);
    Scene speck;
    speck.add(10, 10, 4, 6, true);
    speck.add(11, 10, 4, 5, true);  // three of eight
    CHECK(downsample(kCoarse, alone(speck.build(kFine, ground))) == nullptr);
    speck.add(11, 10, 5, 6, true);
    CHECK(downsample(kCoarse, alone(speck.build(kFine, ground))) != nullptr);
}

TEST_CASE("each child lands in its own octant", "[common][voxel][downsample]") {
    const auto slot = GENERATE(range(std::size_t{0}, std::size_t{8}));
    Scene cube;
    for (int i = 0; i < 4; ++i)
        cube.add(6 + i % 2, 8 + i / 2, 10, 12, true);
    const auto coarse = downsample(kCoarse, alone(cube.build(kFine, ground), slot));
    INFO("slot " << slot);
    REQUIRE(coarse);
    CHECK(solid_in(*coarse) == 1);
    CHECK(coarse->solid(3 + 32 * static_cast<int>(slot & 1), 5 + 128 * static_cast<int>(slot >> 2),
                        4 + 32 * static_cast<int>(slot >> 1 & 1)));
}

TEST_CASE("a sheet one voxel thick survives every level", "[common][voxel][downsample]") {
    struct Case {
        const char* name;
        int roof_y;
        int wall_x;
    };
    const auto c = GENERATE(values<Case>({
        {"a roof at an even height", 36, -1},
        {"a roof at an odd height", 37, -1},
        {"a roof at the top of the box", 255, -1},
        {"a wall at an even place", -1, 20},
        {"a wall at an odd place", -1, 21},
        {"a wall at the edge of the box", -1, 63},
    }));
    DYNAMIC_SECTION(c.name) {
        Scene scene;
        for (int z = 0; z < 64; ++z)
            for (int x = 0; x < 64; ++x)
                if (c.wall_x < 0)
                    scene.add(x, z, c.roof_y, c.roof_y + 1, true);
                else if (x == c.wall_x)
                    scene.add(x, z, 0, 256, true);
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
