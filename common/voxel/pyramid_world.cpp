#include "common/voxel/pyramid_world.hpp"

#include <algorithm>

#include "common/util/error.hpp"
#include "common/voxel/box_builder.hpp"

namespace terravox::voxel {

int levels_for(const VoxelBounds& bounds) noexcept {
    const std::int64_t widest = std::max(std::int64_t{bounds.max[0]} - bounds.min[0],
                                         std::int64_t{bounds.max[2]} - bounds.min[2]);
    int levels = 1;
    while (levels < kMaxLevel && (std::int64_t{kBoxSizeX} << (levels - 1)) < widest)
        ++levels;
    return levels;
}

void check_level(const WorldInfo& world, int level) {
    if (level < 0 || level >= world.levels)
        throw util::UsageError("make a box: level {}; allowed: 0 to {}", level, world.levels - 1);
}

ColumnExtent column_of_bounds(const VoxelBounds& bounds, int level, std::int32_t bx,
                              std::int32_t bz) noexcept {
    if (bounds.empty())
        return {};
    const BoxRange range = boxes_over(bounds, level);
    return range.contains({level, bx, range.min.by, bz}) ? ColumnExtent{range.min.by, range.max.by}
                                                         : ColumnExtent{};
}

std::shared_ptr<const Box> PyramidWorld::box(const BoxKey& key) {
    check_level(info(), key.level);
    if (info().bounds.empty() || !boxes_over(info().bounds, key.level).contains(key) ||
        !may_hold_column(key.level, key.bx, key.bz))
        return nullptr;
    return key.level == 0 ? fine_box(key) : coarse_box(key);
}

std::shared_ptr<const Box> PyramidWorld::fine_box(const BoxKey& key) {
    const auto column = m_fine.get(
        {0, key.bx, 0, key.bz},
        [&] { return std::make_shared<const FineColumn>(make_column(key.bx, key.bz)); },
        [](const auto& made) {
            std::size_t bytes = sizeof(FineColumn);
            for (const auto& box : made->boxes)
                bytes += sizeof(box) + (box ? box->memory_bytes() : 0);
            return bytes;
        });
    const std::int64_t index = std::int64_t{key.by} - column->by_begin;
    return index >= 0 && index < static_cast<std::int64_t>(column->boxes.size())
               ? column->boxes[static_cast<std::size_t>(index)]
               : nullptr;
}

std::shared_ptr<const Box> PyramidWorld::coarse_box(const BoxKey& key) {
    return m_coarse.get(
        key,
        [&] {
            return downsample(
                key, Pyramid::children(key, [&](const BoxKey& child) { return box(child); }));
        },
        [](const auto& made) { return made ? made->memory_bytes() : 0; });
}

ColumnExtent PyramidWorld::column(int level, std::int32_t bx, std::int32_t bz) {
    const ColumnExtent out = column_of_bounds(info().bounds, level, bx, bz);
    return out.empty() || may_hold_column(level, bx, bz) ? out : ColumnExtent{};
}

bool PyramidWorld::may_hold(const BoxRange& boxes) {
    if (info().bounds.empty())
        return false;
    // Chooses a level at which few columns cover the boxes.
    constexpr std::int32_t kMaxAcross = 4;
    BoxRange at = boxes;
    const auto few = [&] {
        return at.max.bx - at.min.bx <= kMaxAcross && at.max.bz - at.min.bz <= kMaxAcross;
    };
    while (!few() && at.min.level + 1 < info().levels) {
        ++at.min.level;
        for (const auto axis : {&BoxKey::bx, &BoxKey::bz}) {
            at.min.*axis = floor_div(at.min.*axis, 2);
            at.max.*axis = floor_div(at.max.*axis - 1, 2) + 1;
        }
    }
    if (!few())
        return true;
    const BoxRange all = boxes_over(info().bounds, at.min.level);
    for (std::int32_t bx = std::max(at.min.bx, all.min.bx); bx < std::min(at.max.bx, all.max.bx);
         ++bx)
        for (std::int32_t bz = std::max(at.min.bz, all.min.bz);
             bz < std::min(at.max.bz, all.max.bz); ++bz)
            if (may_hold_column(at.min.level, bx, bz))
                return true;
    return false;
}

}  // namespace terravox::voxel
