#include "voxelserver/voxelize/serialize.hpp"

#include <algorithm>

#include "common/voxel/box_builder.hpp"

namespace terravox::voxelize {
namespace {

using voxel::Material;
using voxel::VoxelAttr;

VoxelAttr attr_at(std::span<const Run> runs, std::int32_t y) {
    const auto run = std::upper_bound(runs.begin(), runs.end(), y, [](std::int32_t value, const Run& r) { return value < r.y1; });
    if (run == runs.end() || y < run->y0) return {};
    if (!run->terrain || y == run->y1 - 1) return run->attr;
    VoxelAttr below;
    below.material = run->y1 - 1 - y <= run->soil ? Material::kSoil : Material::kRock;
    below.source_class = run->attr.source_class;
    return below;
}

bool takes_ortho(Material m) { return m != Material::kWall && m != Material::kWater && m != Material::kSoil && m != Material::kRock && m != Material::kWire; }

}  // namespace

std::shared_ptr<const voxel::Box> serialize(const voxel::BoxKey& key, const PatchRuns& runs, const PatchColours& colours) {
    const std::int32_t base = key.by * voxel::kBoxSizeY;
    if (runs.max_y() <= base || runs.min_y() >= base + voxel::kBoxSizeY) return nullptr;
    voxel::BoxBuilder builder;
    for (int z = -1; z <= kPatchSize; ++z)
        for (int x = -1; x <= kPatchSize; ++x)
            for (const Run& run : runs.column(x, z)) {
                if (run.y1 < base || run.y0 > base + voxel::kBoxSizeY) continue;
                builder.add(x, z, std::max(run.y0 - base, -1), std::min(run.y1 - base, voxel::kBoxSizeY + 1), !voxel::see_through(run.attr.material));
            }
    return builder.build(key, [&](int x, int y, int z) {
        VoxelAttr attr = attr_at(runs.column(x, z), base + y);
        const auto i = static_cast<std::size_t>(z * kPatchSize + x);
        if (!colours.valid.empty() && colours.valid[i] != 0 && takes_ortho(attr.material)) {
            attr.colour = colours.colour[i];
            attr.flags |= VoxelAttr::kHasColour;
        }
        return attr;
    });
}

}  // namespace terravox::voxelize
