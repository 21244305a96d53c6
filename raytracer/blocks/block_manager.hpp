#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "common/voxel/world.hpp"

namespace terravox::blocks {

/// A box as the walker meets it. A hole is a box that could not be made or fetched: it is shown and
/// counted, never treated as air.
struct Block {
    std::shared_ptr<const voxel::Box> box;  ///< nullptr: air, or a hole
    bool hole = false;
    [[nodiscard]] std::size_t memory_bytes() const noexcept {
        return kOverhead_bytes + (box ? box->memory_bytes() : 0);
    }
    /// Bytes of an entry and its place in maps and lists.
    static constexpr std::size_t kOverhead_bytes = 256;
};
/// Keeps its box in memory while it exists: the box is not evicted.
using BlockPin = std::shared_ptr<const Block>;

/// Notified when boxes that it waits for have arrived.
class BlockListener {
public:
    virtual ~BlockListener() = default;
    /// Called once for each wait, from any thread and with the manager's lock held: it must be
    /// short and must not call the manager.
    /// @return whether the box will be read by the waiting side; it stays in memory until then
    virtual bool block_came(const voxel::BoxKey& key, std::uint64_t ticket) noexcept = 0;
};

struct BlockStats {
    struct Level {
        std::uint64_t loaded = 0, evicted = 0, reloaded = 0, bytes_loaded = 0;
    };
    std::array<Level, voxel::kMaxLevel + 1> levels{};
    /// Of find(): lookups that the readers' own caches could not answer.
    std::uint64_t hits = 0, misses = 0;
    std::uint64_t waits = 0;  ///< times that a tile's rays had to wait for a box
    std::size_t bytes = 0, peak_bytes = 0, entries = 0, holes = 0;
};

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
/// soon as it has arrived, whatever becomes of the others of its batch. Thread-safe: one lock, not
/// held while the world makes a box.
class BlockManager {
public:
    /// @param memory_bytes limit for boxes
    /// @param loaders threads that request boxes from the world, at least 1
    BlockManager(voxel::World& world, std::size_t memory_bytes, int loaders = 2);
    /// Stops the world's requests and ends the loaders.
    ~BlockManager();
    BlockManager(const BlockManager&) = delete;
    BlockManager& operator=(const BlockManager&) = delete;

    /// @return nullptr when the box is not in memory
    [[nodiscard]] BlockPin find(const voxel::BoxKey& key);
    /// Calls listener.block_came(key, ticket) once the box is in memory; at once when it is.
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
    [[nodiscard]] std::size_t limit_bytes() const noexcept { return m_limit_bytes; }
    [[nodiscard]] BlockStats stats() const;
    /// Number of boxes that could not be made or fetched so far.
    [[nodiscard]] std::size_t hole_count() const;
    /// Whether this box could not be made or fetched. If so, it remains so until forget_holes().
    [[nodiscard]] bool is_hole(const voxel::BoxKey& key) const;

private:
    struct Wait {
        BlockListener* listener;
        std::uint64_t ticket;
    };
    struct Entry {
        BlockPin block;                            ///< nullptr while it is queued or being loaded
        std::list<voxel::BoxKey>::iterator place;  ///< in m_order, only with a block
        std::vector<Wait> waits;
        bool loading = false, wanted = false;
        int getters = 0;      ///< threads in get(); the entry is kept while there are any
        bool unseen = false;  ///< arrived for a waiter that has not read it yet
    };
    void load_boxes();
    [[nodiscard]] bool next_keys(std::vector<voxel::BoxKey>& keys);
    void take_wanted(std::size_t most, std::vector<voxel::BoxKey>& keys);
    void take_prefetched(std::size_t most, std::vector<voxel::BoxKey>& keys);
    [[nodiscard]] std::size_t share_of(std::size_t queued) const noexcept;
    [[nodiscard]] std::size_t coming_bytes(std::size_t more) const noexcept;
    [[nodiscard]] std::vector<voxel::BoxKey> load(const std::vector<voxel::BoxKey>& keys);
    /// @param failure null: it was a hole before, or loading has been stopped
    [[nodiscard]] bool come_as_hole(const voxel::BoxKey& key, const std::exception_ptr& failure,
                                    std::uint64_t forgotten);
    void come(const voxel::BoxKey& key, Block made);
    void come(const voxel::BoxKey& key, Block made, std::unique_lock<std::mutex> lock);
    void keep(const voxel::BoxKey& key, BlockPin block, std::vector<BlockPin>& evicted);
    void evict(std::vector<BlockPin>& evicted);
    void touch(Entry& entry);
    void note_hole(const voxel::BoxKey& key, const std::exception_ptr& failure);

    voxel::World& m_world;
    const std::size_t m_limit_bytes;
    const std::size_t m_batch;  ///< greatest number of boxes per request
    const std::size_t m_loader_count;
    const std::size_t m_max_ahead;  ///< loaders that may request boxes without a waiter
    std::array<voxel::BoxRange, voxel::kMaxLevel + 1> m_ranges;
    const BlockPin m_air = std::make_shared<const Block>();

    mutable std::mutex m_mutex;
    std::condition_variable m_work, m_came;
    std::unordered_map<voxel::BoxKey, Entry, voxel::BoxKeyHash> m_entries;
    std::list<voxel::BoxKey> m_order;  ///< least recently used last
    std::deque<voxel::BoxKey> m_wanted, m_prefetched;
    std::unordered_set<voxel::BoxKey, voxel::BoxKeyHash> m_loaded_once;
    BlockStats m_stats;
    std::size_t m_unseen_bytes = 0, m_freed_bytes = 0;
    std::size_t m_busy = 0;    ///< loaders with a request under way
    std::size_t m_ahead = 0;   ///< those of them whose boxes had no waiter when they began
    std::size_t m_coming = 0;  ///< boxes that they have requested
    bool m_stop = false;
    std::set<voxel::BoxKey> m_holes;
    std::uint64_t m_forgotten = 0;  ///< how often forget_holes() was called
    std::set<std::string> m_hole_reasons;
    std::exception_ptr m_changed;  ///< the first ChangedError
    std::vector<std::thread> m_loaders;
};

}  // namespace terravox::blocks
