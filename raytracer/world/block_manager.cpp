#include "raytracer/world/block_manager.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"

namespace terravox {

BlockRef BlockManager::get(const voxel::BoxKey& key) {
    const auto ref = m_cache.get(
        key,
        [&] {
            BlockRef made;
            try {
                made.box = m_world.box(key);
            } catch (const std::exception& e) {
                // One box less must not lose the picture; it stays visible, counted and in the exit code.
                made.hole = true;
                const std::lock_guard lock(m_holes_mutex);
                // A damaged file fails in the same words for each of its boxes: said once, the boxes are counted at the end.
                if (m_holes.insert(key).second && m_hole_reasons.size() < kMostReasons && m_hole_reasons.insert(e.what()).second)
                    spdlog::error("hole at box {}: {}", voxel::to_string(key), e.what());
            }
            return std::make_shared<const BlockRef>(std::move(made));
        },
        [](const auto& r) { return sizeof(BlockRef) + (r->box ? r->box->memory_bytes() : 0); });
    return *ref;
}

std::size_t BlockManager::hole_count() const {
    const std::lock_guard lock(m_holes_mutex);
    return m_holes.size();
}

void BlockManager::prefetch(int level, const voxel::VoxelBounds& bounds, int threads, const std::atomic<bool>& stop) {
    const auto range = voxel::boxes_over(bounds, level);
    const auto width = static_cast<std::size_t>(range.max.bx - range.min.bx), depth = static_cast<std::size_t>(range.max.bz - range.min.bz);
    std::atomic<bool> full{false};
    // A world of places far apart has millions of columns: not a task for each, or stopping would take as long as going on.
    constexpr std::size_t kMostTasks = 65'536;
    const std::size_t columns = width * depth, tasks = std::min(columns, kMostTasks);
    thread::parallel_for(tasks, threads, [&](std::size_t task) {
        for (std::size_t i = columns * task / tasks; i < columns * (task + 1) / tasks && !stop && !full; ++i) {
            const auto bx = range.min.bx + static_cast<std::int32_t>(i % width), bz = range.min.bz + static_cast<std::int32_t>(i / width);
            for (std::int32_t by = range.min.by; by < range.max.by; ++by) (void)get({level, bx, by, bz});
            if (m_cache.stats().bytes > m_cache.limit_bytes() / 4 * 3) full = true;
        }
    });
}

}  // namespace terravox
