#pragma once

#include <array>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "common/voxel/world.hpp"
#include "raytracer/core/blocks/block.hpp"
#include "raytracer/core/blocks/block_cache.hpp"
#include "raytracer/core/blocks/load_queue.hpp"

namespace terravox::blocks {

/// The boxes of a world in memory, hashed by Morton code, and the threads that fetch missing ones.
///
/// Tracing threads never block here: find() returns at once, and wait_for() calls back when the box
/// has arrived. Boxes with a waiter are loaded before those that are only prefetched (prefetch). At
/// the memory limit the least recently used boxes are evicted, but never one that is pinned or that
/// has arrived for a waiter which has not read it yet; loaders pause while such boxes fill a
/// quarter of the memory.
///
/// Where the world prefers batches, a loader takes a share of the queue, the most urgent boxes
/// first, and two loaders in eight are reserved for boxes with a waiter. Each box is available as
/// soon as it has arrived, whatever becomes of the others of its batch.
///
/// Thread-safe: one lock, not held while the world makes a box. It guards the cache (which boxes
/// are in memory, and which is evicted), the queue (which is loaded next) and the record of holes;
/// this class adds the lock, the loaders and the wake-ups.
class BlockManager {
public:
    /// @param memory_bytes limit for boxes
    /// @param loaders threads that request boxes from the world, at least 1
    BlockManager(voxel::World& world, std::size_t memory_bytes, int loaders = 2);
    /// Stops the world's requests and ends the loaders.
    ~BlockManager();

    /// @return nullptr when the box is not in memory
    [[nodiscard]] BlockPin find(const voxel::BoxKey& key);
    /// Calls listener.on_block_loaded(key, ticket) once the box is in memory; at once when it is.
    void wait_for(const voxel::BoxKey& key, BlockListener& listener, std::uint64_t ticket);
    /// After this, no call reaches the listener, and boxes that have arrived for it are no longer
    /// reserved.
    /// @param ticket of the waits to forget; nullopt: all of them
    void forget(const BlockListener& listener, std::optional<std::uint64_t> ticket = std::nullopt);
    /// Blocks until the box is available; returns a hole once stop() was called. Not for tracing
    /// threads.
    [[nodiscard]] BlockPin get(const voxel::BoxKey& key);
    /// Boxes to load, in this order, while no box with a waiter is queued, until three quarters of
    /// the memory are full. Replaces earlier prefetches.
    void prefetch(std::vector<voxel::BoxKey> keys);

    /// From now on, boxes that were not available are requested again. To be called between
    /// pictures, each of which needs one answer per box. A request made before this call that fails
    /// after it is repeated once: it may have been cancelled by a user that no longer needed it.
    void forget_holes();

    /// @throws voxel::ChangedError once a box was not available because the world's data changed.
    /// Such boxes are holes that are not reported one by one: a caller that keeps a result must
    /// call this before it accepts one with holes.
    void check_world() const;

    /// Ends all loading: no more boxes are requested, and requests under way are cancelled.
    void stop();

    [[nodiscard]] const voxel::WorldInfo& world_info() const noexcept { return m_world.info(); }
    [[nodiscard]] std::size_t limit_bytes() const noexcept { return m_cache.limit_bytes(); }
    [[nodiscard]] BlockStats stats() const;
    /// Number of boxes that could not be made or fetched so far.
    [[nodiscard]] std::size_t hole_count() const;
    /// Whether this box could not be made or fetched. If so, it remains so until forget_holes().
    [[nodiscard]] bool is_hole(const voxel::BoxKey& key) const;

private:
    using Entry = BlockCache::Entry;
    void load_boxes();
    [[nodiscard]] bool next_request(LoadQueue::Request& request);
    [[nodiscard]] std::vector<voxel::BoxKey> load(const std::vector<voxel::BoxKey>& keys);
    /// @param failure null: it was a hole before, or loading has been stopped
    [[nodiscard]] bool on_load_failed(const voxel::BoxKey& key, const std::exception_ptr& failure,
                                      std::uint64_t generation);
    void on_loaded(const voxel::BoxKey& key, Block made);
    void on_loaded(const voxel::BoxKey& key, Block made, std::unique_lock<std::mutex> lock);
    void keep(const voxel::BoxKey& key, BlockPin block, std::vector<BlockPin>& evicted);
    void touch(Entry& entry);
    void request(const voxel::BoxKey& key, Entry& entry);

    voxel::World& m_world;
    std::array<voxel::BoxRange, voxel::kMaxLevel + 1> m_ranges;
    const BlockPin m_air = std::make_shared<const Block>();

    mutable std::mutex m_mutex;        ///< guards all that follows but the threads
    std::condition_variable m_work;    ///< for loaders: there may be boxes to load, or an end
    std::condition_variable m_loaded;  ///< for get(): a box has arrived, or an end
    BlockCache m_cache;
    LoadQueue m_queue;
    HoleRecord m_holes;
    std::size_t m_freed_bytes = 0;  ///< since memory was last given back to the system
    bool m_stop = false;
    std::vector<std::thread> m_loaders;
};

}  // namespace terravox::blocks
