#include "voxelserver/make/worlds/luanti/column_boxes.hpp"

#include "common/voxel/box_builder.hpp"

namespace terravox::luanti {
namespace {

enum class Kind : std::uint8_t { kAir, kOpaque, kClear };

// Coordinates in the box, including its margin of one voxel.
const voxel::VoxelAttr* attr_at(const BoxBlocks& blocks, int x, int y, int z) noexcept {
    const NodeBlock* const block = blocks.at(x >> 4, y >> 4, z >> 4).get();
    return block == nullptr ? nullptr : &block->at(x & 15, y & 15, z & 15);
}

Kind kind_at(const BoxBlocks& blocks, int x, int y, int z) noexcept {
    const voxel::VoxelAttr* const attr = attr_at(blocks, x, y, z);
    if (attr == nullptr || attr->material == voxel::Material::kAir)
        return Kind::kAir;
    return voxel::see_through(attr->material) ? Kind::kClear : Kind::kOpaque;
}

// Adds the runs of voxels of one kind. Around the box only opaque voxels count: they hide what is
// inside.
void add_column(const BoxBlocks& blocks, int x, int z, voxel::BoxBuilder& builder) {
    constexpr int kEnd = voxel::kBoxSizeY + 1;
    const bool is_inside = x >= 0 && x < voxel::kBoxSizeX && z >= 0 && z < voxel::kBoxSizeZ;
    Kind kind = Kind::kAir;
    int begin = -1;
    for (int y = -1; y <= kEnd; ++y) {
        const Kind next = y < kEnd ? kind_at(blocks, x, y, z) : Kind::kAir;
        if (next == kind)
            continue;
        if (kind == Kind::kOpaque || (kind == Kind::kClear && is_inside))
            builder.add(x, z, begin, y, kind == Kind::kOpaque);
        kind = next;
        begin = y;
    }
}

}  // namespace

std::shared_ptr<const voxel::Box> box_of(const BoxBlocks& blocks, const voxel::BoxKey& key) {
    voxel::BoxBuilder builder;
    for (int z = -1; z <= voxel::kBoxSizeZ; ++z) {
        for (int x = -1; x <= voxel::kBoxSizeX; ++x)
            add_column(blocks, x, z, builder);
    }
    return builder.build(key, [&](int x, int y, int z) { return *attr_at(blocks, x, y, z); });
}

}  // namespace terravox::luanti
