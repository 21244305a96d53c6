#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <set>
#include <string>

#include "common/util/cache.hpp"
#include "common/voxel/world.hpp"

namespace terravox {

/// A box as the walker meets it. A hole is a box that could not be made or fetched: it is shown and counted, never taken for air.
struct BlockRef {
    std::shared_ptr<const voxel::Box> box;  ///< nullptr: air, or a hole
    bool hole = false;
};

/// The boxes of a world in memory: a cache hashed by Morton code with a byte limit, which asks the world for what is missing.
/// Several threads that miss the same box wait for one making. Thread-safe.
class BlockManager {
public:
    BlockManager(voxel::World& world, std::size_t memory_bytes) : m_world(world), m_cache(memory_bytes) {}

    [[nodiscard]] BlockRef get(const voxel::BoxKey& key);
    [[nodiscard]] const voxel::WorldInfo& world_info() const noexcept { return m_world.info(); }
    [[nodiscard]] util::CacheStats stats() const { return m_cache.stats(); }
    [[nodiscard]] std::size_t limit_bytes() const noexcept { return m_cache.limit_bytes(); }
    /// Boxes that could not be made or fetched so far.
    [[nodiscard]] std::size_t hole_count() const;

    /// Makes boxes ahead on all cores, nearest columns of boxes first, until the memory limit is three quarters full.
    void prefetch(int level, const voxel::VoxelBounds& bounds, int threads, const std::atomic<bool>& stop);

private:
    voxel::World& m_world;
    util::Cache<voxel::BoxKey, BlockRef, voxel::BoxKeyHash> m_cache;
    mutable std::mutex m_holes_mutex;
    std::set<voxel::BoxKey> m_holes;
    static constexpr std::size_t kMostReasons = 100;
    std::set<std::string> m_hole_reasons;
};

}  // namespace terravox
