#include "raytracer/blocks/packed_box.hpp"

#include "common/voxel/box_builder.hpp"
#include "tests/catch.hpp"

using namespace terravox;
using blocks::Block;
using voxel::Box;
using voxel::Material;
using voxel::VoxelAttr;

namespace {

constexpr voxel::BoxKey kKey{2, -3, 0, 7};

/// Uneven ground below water, whose colour changes from one strip of columns to the next, and at z
/// = 48.
std::shared_ptr<const Box> lake(int water, int wide) {
    voxel::BoxBuilder builder;
    const auto ground = [](int x, int z) { return 5 + (x * 7 + z * 3 & 15); };
    for (int z = -1; z <= 64; ++z)
        for (int x = -1; x <= 64; ++x) {
            builder.add(x, z, -1, ground(x, z), true);
            builder.add(x, z, ground(x, z), water, false);
        }
    return builder.build(kKey, [&](int x, int y, int z) {
        VoxelAttr attr;
        attr.material = y < ground(x, z) ? Material::kSand : Material::kWater;
        attr.colour = {static_cast<std::uint8_t>(x / wide), static_cast<std::uint8_t>(z / 48), 0};
        return attr;
    });
}

int differing_voxels(const Box& a, const Box& b) {
    int out = 0;
    for (int y = 0; y < voxel::kBoxSizeY; ++y)
        for (int z = 0; z < voxel::kBoxSizeZ; ++z)
            for (int x = 0; x < voxel::kBoxSizeX; ++x)
                out += a.voxel(x, y, z) != b.voxel(x, y, z) ? 1 : 0;
    return out;
}

}  // namespace

TEST_CASE("a box of deep water takes a fraction of the memory, with the same voxels",
          "[raytracer][blocks]") {
    const auto box = lake(200, 64);
    const Block block = blocks::packed(lake(200, 64));
    REQUIRE(block.box);
    CHECK_FALSE(block.hole);
    CHECK(block.box->key() == kKey);
    CHECK(block.box->memory_bytes() < box->memory_bytes() / 4);
    CHECK(block.box->top() == box->top());
    CHECK(differing_voxels(*block.box, *box) == 0);
}

TEST_CASE("bricks share attributes by what they are full of, up to sixteen kinds",
          "[raytracer][blocks]") {
    struct Case {
        int wide;
        std::uint32_t kinds;
    };
    for (const Case& c : {Case{64, 2}, Case{16, 8}, Case{8, 16}, Case{4, 16}, Case{3, 0}}) {
        INFO("a colour for each " << c.wide << " columns");
        const Block block = blocks::packed(lake(200, c.wide));
        CHECK(block.shared_attrs == c.kinds * 64);
        CHECK(differing_voxels(*block.box, *lake(200, c.wide)) == 0);
    }
}

TEST_CASE("a box stays what it is where packing would not save half of it", "[raytracer][blocks]") {
    auto shallow = lake(24, 64);
    const Box* const before = shallow.get();
    const Block block = blocks::packed(std::move(shallow));
    CHECK(block.box.get() == before);
    CHECK(block.shared_attrs == 0);
    CHECK(blocks::packed(nullptr).box == nullptr);
}

TEST_CASE("a box that the world keeps is not packed: there would be two", "[raytracer][blocks]") {
    const auto kept = lake(200, 64);
    const Block block = blocks::packed(kept);
    CHECK(block.box == kept);
    CHECK(block.shared_attrs == 0);
}
