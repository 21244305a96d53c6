#include "voxelserver/make/voxelize/steps/serialize.hpp"

#include <algorithm>

#include "common/voxel/box_builder.hpp"

namespace terravox::voxelize {
namespace {

using voxel::Material;
using voxel::VoxelAttr;

// Whether an image shows a run: the topmost surface and the foliage of crowns; not walls, beds or
// trunks, nor the ground under a bridge.
bool shows(const Run& run, bool topmost) noexcept {
    const Material m = run.attr.material;
    if (m == Material::kWall || m == Material::kWater || m == Material::kWire ||
        m == Material::kTrunk)
        return false;
    return topmost || voxel::is_plant(m);
}

VoxelAttr attr_at(std::span<const Run> runs, std::int32_t y, const voxel::Rgb8* seen_from_above) {
    const auto run = std::upper_bound(
        runs.begin(), runs.end(), y, [](std::int32_t value, const Run& r) { return value < r.y1; });
    if (run == runs.end() || y < run->y0)
        return {};
    VoxelAttr out;
    if (run->terrain && y != run->y1 - 1) {
        out.material = run->y1 - 1 - y <= run->soil ? Material::kSoil : Material::kRock;
        out.source_class = run->attr.source_class;
        return out;
    }
    out = run->attr;
    if (seen_from_above != nullptr && shows(*run, run + 1 == runs.end())) {
        out.colour = *seen_from_above;
        out.flags =
            static_cast<std::uint8_t>((out.flags & ~VoxelAttr::kTinted) | VoxelAttr::kHasColour);
    }
    return out;
}

}  // namespace

std::shared_ptr<const voxel::Box> serialize(const voxel::BoxKey& key, const PatchRuns& runs,
                                            const SurfaceAppearance& appearance) {
    const std::int32_t base = key.by * voxel::kBoxSizeY;
    if (runs.max_y() <= base || runs.min_y() >= base + voxel::kBoxSizeY)
        return nullptr;
    voxel::BoxBuilder builder;
    for (int z = -1; z <= grid::kPatchSize; ++z)
        for (int x = -1; x <= grid::kPatchSize; ++x)
            for (const Run& run : runs.column(x, z)) {
                if (run.y1 < base || run.y0 > base + voxel::kBoxSizeY)
                    continue;
                builder.add(x, z, std::max(run.y0 - base, -1),
                            std::min(run.y1 - base, voxel::kBoxSizeY + 1),
                            !voxel::see_through(run.attr.material));
            }
    return builder.build(key, [&](int x, int y, int z) {
        return attr_at(runs.column(x, z), base + y, appearance.colour(x, z));
    });
}

}  // namespace terravox::voxelize
