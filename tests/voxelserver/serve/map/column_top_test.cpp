#include "voxelserver/serve/map/column_top.hpp"

#include <vector>

#include "common/util/error.hpp"
#include "common/util/linear_light.hpp"
#include "tests/catch.hpp"
#include "tests/common/voxel/scene.hpp"
#include "tests/voxelserver/serve/map/colours.hpp"

using namespace terravox;
using voxel::Box;
using voxel::Material;
using voxel::VoxelAttr;

namespace {

using Boxes = std::vector<std::shared_ptr<const Box>>;

/// The highest voxel of a column, looked for one by one from the top.
std::optional<std::pair<std::int32_t, VoxelAttr>> plain_top(const Boxes& boxes, int x, int z) {
    std::optional<std::pair<std::int32_t, VoxelAttr>> out;
    for (const auto& box : boxes)
        for (int y = 0; box && y < voxel::kBoxSizeY; ++y)
            if (const auto attr = box->voxel(x, y, z);
                attr && (!out || box->key().by * 256 + y > out->first))
                out = {{box->key().by * 256 + y, *attr}};
    return out;
}

VoxelAttr of(Material material, std::optional<voxel::Rgb8> colour = {}) {
    VoxelAttr out;
    out.material = material;
    if (colour) {
        out.flags = VoxelAttr::kHasColour;
        out.colour = *colour;
    }
    return out;
}

/// One level slab of one kind.
std::shared_ptr<const Box> slab(std::int32_t by, int height, const VoxelAttr& attr) {
    test::Scene scene;
    for (int z = -1; z <= 64; ++z)
        for (int x = -1; x <= 64; ++x)
            scene.add(x, z, -1, height, true);
    return scene.build({0, 0, by, 0}, [&](int, int, int) { return attr; });
}

}  // namespace

TEST_CASE("a box column from above is what its columns show from the top", "[map][top]") {
    const auto colours = test::test_colours();
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        Boxes boxes;
        for (std::int32_t by = -2; by < static_cast<std::int32_t>(seed % 3); ++by)
            boxes.push_back(test::random_scene(seed * 10 + static_cast<std::uint64_t>(by + 2))
                                .build({0, -5, by, 7}, test::to_attr));
        if (seed % 2 == 0)
            std::swap(boxes.front(), boxes.back());
        boxes.insert(boxes.begin() + 1, nullptr);
        const auto top = map::make_top(boxes, colours);
        REQUIRE(top);
        int wrong = 0;
        for (int z = 0; z < 64; ++z)
            for (int x = 0; x < 64; ++x) {
                const auto expected = plain_top(boxes, x, z);
                const map::ColumnTop& got = top->at(x, z);
                if (!expected)
                    wrong += got.nothing() ? 0 : 1;
                else
                    wrong += got.y == expected->first && got.material == expected->second.material
                                 ? 0
                                 : 1;
            }
        INFO("seed " << seed);
        CHECK(wrong == 0);
    }
}

TEST_CASE("true colours are mixed into those of materials in linear light", "[map][top]") {
    const auto colours = test::test_colours();
    const auto to_colour = [&](const VoxelAttr& attr) {
        return map::make_top(Boxes{slab(0, 9, attr)}, colours)->at(3, 60).colour;
    };
    CHECK(to_colour(of(Material::kRoad)) == colours.palette.of(Material::kRoad).colour);
    const voxel::Rgb8 shown{200, 30, 90};
    struct Case {
        Material material;
        int percent;
    };
    for (const auto [material, percent] : {Case{Material::kRoad, 85}, Case{Material::kWater, 45}}) {
        const auto plain = colours.palette.of(material).colour;
        const auto mixed = [&](std::uint8_t a, std::uint8_t b) {
            const double linear =
                util::to_linear(a) * (100 - percent) / 100.0 + util::to_linear(b) * percent / 100.0;
            return util::to_srgb(static_cast<std::uint32_t>(linear + 0.5));
        };
        CHECK(to_colour(of(material, shown)) == voxel::Rgb8{mixed(plain.r, shown.r),
                                                            mixed(plain.g, shown.g),
                                                            mixed(plain.b, shown.b)});
    }
}

TEST_CASE("hidden rock under the sky of its box is still a top", "[map][top]") {
    // The margin says that a box above goes on, but that box is not given: bricks and larger cells
    // without detail are met.
    test::Scene scene;
    for (int z = -1; z <= 64; ++z)
        for (int x = -1; x <= 64; ++x)
            scene.add(x, z, -1, 257, true);
    const auto box = scene.build({0, 0, -1, 0}, test::to_attr);
    const auto top = map::make_top(Boxes{box}, test::test_colours());
    REQUIRE(top);
    CHECK(top->at(0, 0).y == -1);
    CHECK(top->at(63, 31).material == Material::kRock);
}

TEST_CASE("nothing is nothing, and what calls itself air is still seen", "[map][top]") {
    const auto colours = test::test_colours();
    CHECK(map::make_top({}, colours) == nullptr);
    CHECK(map::make_top(Boxes{nullptr, nullptr}, colours) == nullptr);
    CHECK(map::make_top(Boxes{slab(0, 9, of(Material::kAir))}, colours)->at(0, 0).material ==
          Material::kUnknown);
}

TEST_CASE("boxes that do not stand on each other are refused", "[map][top]") {
    const auto colours = test::test_colours();
    const auto build = [](const voxel::BoxKey& key) {
        return test::random_scene(1).build(key, test::to_attr);
    };
    CHECK_THROWS_AS(map::make_top(Boxes{build({0, 0, 0, 0}), build({0, 1, 1, 0})}, colours),
                    util::Error);
    CHECK_THROWS_AS(map::make_top(Boxes{build({0, 0, 0, 0}), build({0, 0, 1, -1})}, colours),
                    util::Error);
    CHECK_THROWS_WITH(map::make_top(Boxes{build({1, 0, 0, 0})}, colours),
                      test::contains("1/0/0/0"));
}
