#include "voxelserver/out/export/archive/archive_box.hpp"

#include <algorithm>
#include <array>
#include <bit>

#include "common/voxel/box_builder.hpp"
#include "common/voxel/pyramid_world.hpp"

namespace terravox::exports {
namespace {

using voxel::Box;
using voxel::BoxKey;

// The box without the voxels outside the limits.
std::shared_ptr<const Box> cut(const std::shared_ptr<const Box>& box,
                               const voxel::VoxelBounds& limits) {
    const std::array<std::int32_t, 3> size{voxel::kBoxSizeX, voxel::kBoxSizeY, voxel::kBoxSizeZ};
    const std::array<std::int32_t, 3> at{box->key().bx * size[0], box->key().by * size[1],
                                         box->key().bz * size[2]};
    std::array<int, 3> low{};
    std::array<int, 3> high{};
    bool whole = true;
    for (std::size_t a = 0; a < 3; ++a) {
        low[a] = std::clamp(limits.min[a] - at[a], 0, size[a]);
        high[a] = std::clamp(limits.max[a] - at[a], 0, size[a]);
        whole = whole && low[a] == 0 && high[a] == size[a];
    }
    if (whole)
        return box;
    voxel::BoxBuilder builder;
    for (int x = low[0]; x < high[0]; ++x)
        for (int z = low[2]; z < high[2]; ++z)
            for (int y = low[1]; y < high[1]; ++y)
                if (const auto voxel = box->voxel(x, y, z))
                    builder.add(x, z, y, y + 1, !voxel::see_through(voxel->material));
    return builder.build(box->key(), [&](int x, int y, int z) { return *box->voxel(x, y, z); });
}

std::uint64_t solid_count(const Box& box) {
    const auto cells = box.cells();
    std::uint64_t count = 0;
    const auto walk = [&](const auto& self, const voxel::TreeCell& cell,
                          std::uint64_t child_voxels) -> void {
        if (child_voxels == 1) {
            count += static_cast<std::uint64_t>(std::popcount(cell.mask));
            return;
        }
        count += static_cast<std::uint64_t>(std::popcount(cell.mask & ~cell.detail)) * child_voxels;
        for (std::uint64_t left = cell.detail; left != 0; left &= left - 1)
            self(self, cells[cell.index_of(std::countr_zero(left))], child_voxels / 64);
    };
    for (int root = 0; root < Box::kRootCount; ++root)
        walk(walk, cells[static_cast<std::size_t>(root)], 4096);
    return count;
}

}  // namespace

voxel::WorldInfo archive_info(const Part& part, const voxel::WorldInfo& world) {
    const auto scale = static_cast<double>(std::int64_t{1} << part.level);
    voxel::WorldInfo info = world;
    info.bounds = part.bounds;
    info.voxel_m *= scale;
    info.crs_units_per_voxel *= scale;
    info.levels = voxel::levels_for(info.bounds);
    info.framed = {};
    if (info.typical_heights) {
        info.typical_heights->min >>= part.level;
        info.typical_heights->max = ((info.typical_heights->max - 1) >> part.level) + 1;
    }
    return info;
}

voxel::VoxelBounds archive_limits(const Part& part, const voxel::WorldInfo& world) {
    constexpr std::int32_t kFar = 1 << 30;
    voxel::VoxelBounds limits = part.bounds;
    for (std::size_t a = 0; a < 3; ++a) {
        if (part.bounds.min[a] <= world.bounds.min[a] >> part.level)
            limits.min[a] = -kFar;
        if (part.bounds.max[a] > (world.bounds.max[a] - 1) >> part.level)
            limits.max[a] = kFar;
    }
    return limits;
}

ArchiveBox archive_box(Job& job, const voxel::VoxelBounds& limits, const BoxKey& key) {
    const voxel::BoxOutcome got = job.outcome(key.bx, key.by, key.bz);
    if (got.failure) {
        try {
            std::rethrow_exception(got.failure);
        } catch (const std::exception& e) {
            return {{nullptr, e.what()}, 0};
        }
    }
    const auto box = got.box ? cut(got.box, limits) : nullptr;
    if (!box)
        return {};
    const auto as_finest =
        job.part.level == 0 ? box : Box::from_arrays(key, box->cells(), box->attrs());
    return {{as_finest, std::nullopt}, solid_count(*box)};
}

}  // namespace terravox::exports
