#include "raytracer/core/blocks/block.hpp"

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
    const auto ground = [](int x, int z) { return 5 + ((x * 7 + z * 3) & 15); };
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
