#pragma once

#include <terravox/control.hpp>

#include <cstddef>
#include <cstdint>

#include "common/thread/parallel.hpp"
#include "common/voxel/world.hpp"
#include "raytracer/apps/library/state.hpp"
#include "raytracer/apps/library/steps.hpp"

namespace terravox {

/// A column of boxes of a block.
struct BoxColumnAt {
    std::int32_t bx = 0;
    std::int32_t bz = 0;
    std::int32_t by_begin = 0;  ///< of the boxes of the block in it, half-open
    std::int32_t by_end = 0;
};

/// The boxes over a block, in numbers of boxes of its level.
[[nodiscard]] inline voxel::BoxRange boxes_of(const voxel::VoxelBounds& block, int level) noexcept {
    voxel::BoxRange out = voxel::boxes_over(block, 0);
    out.min.level = out.max.level = level;
    return out;
}

/// Calls work(column) for each column of boxes over a block, on several threads.
/// @param block in voxels of the level
/// @throws Stopped, and what work throws
template <class Work>
void each_box_column(const voxel::VoxelBounds& block, int level, int threads,
                     const Control& control, const Work& work) {
    const voxel::BoxRange range = boxes_of(block, level);
    const auto across = static_cast<std::size_t>(range.max.bx - range.min.bx);
    const auto count = across * static_cast<std::size_t>(range.max.bz - range.min.bz);
    Steps steps(control, count);
    thread::parallel_for(count, threads, [&](std::size_t i) {
        check_stop(control);
        work(BoxColumnAt{range.min.bx + static_cast<std::int32_t>(i % across),
                         range.min.bz + static_cast<std::int32_t>(i / across), range.min.by,
                         range.max.by});
        steps.add_one();
    });
}

}  // namespace terravox
