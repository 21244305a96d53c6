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
/// counted, never taken for air.
struct Block {
    std::shared_ptr<const voxel::Box> box;  ///< nullptr: air, or a hole
    bool hole = false;
    [[nodiscard]] std::size_t memory_bytes() const noexcept {
        return kOverhead_bytes + (box ? box->memory_bytes() : 0);
    }
    static constexpr std::size_t kOverhead_bytes =
        256;  ///< of an entry and its place in maps and lists
};
/// Who holds one keeps it in memory: it is not evicted.
using BlockPin = std::shared_ptr<const Block>;

/// Told when boxes it waits for have come.
class BlockListener {
public:
    virtual ~BlockListener() = default;
    /// Called once for each wait, from any thread, the manager's lock held: must be short and must
    /// not call the manager.
    /// @return somebody will look at the box: it stays in memory until then
    virtual bool block_came(const voxel::BoxKey& key, std::uint64_t ticket) noexcept = 0;
};

struct BlockStats {
    struct Level {
        std::uint64_t loaded = 0, evicted = 0, reloaded = 0, bytes_loaded = 0;
    };
    std::array<Level, voxel::kMaxLevel + 1> levels{};
    std::uint64_t hits = 0, misses = 0;  ///< of find(): what readers did not remember themselves
    std::uint64_t waits = 0;             ///< rays' tiles that had to wait for a box
    std::size_t bytes = 0, peak_bytes = 0, entries = 0, holes = 0;
};

/// The boxes of a world in memory, hashed by Morton code, and the threads that fetch what is
/// missing.
///
/// Nobody who traces ever waits here: find() answers at once, and wait_for() calls back when the
/// box has come. Boxes that somebody waits for are loaded before those that are only foreseen
/// (prefetch). Least recently used boxes go when the limit is reached, never one that is pinned or
/// that has come for somebody who has not looked at it yet; loaders pause while a quarter of the
/// memory is full of such.
///
/// Where the world likes batches a loader takes a share of what is queued, the most urgent first,
/// and two loaders in eight are kept for boxes that somebody waits for. Each box is there as soon
/// as it has come, whatever becomes of the others of its batch. Thread-safe: one lock, not held
/// while the world makes a box.
class BlockManager {
public:
    /// @param memory_bytes limit for boxes @param loaders threads that ask the world, at least 1
    BlockManager(voxel::World& world, std::size_t memory_bytes, int loaders = 2);
    /// Stops the world's requests and ends the loaders.
    ~BlockManager();
    BlockManager(const BlockManager&) = delete;
    BlockManager& operator=(const BlockManager&) = delete;

    /// @return nullptr when the box is not in memory
    [[nodiscard]] BlockPin find(const voxel::BoxKey& key);
    /// Calls listener.block_came(key, ticket) once the box is in memory; at once when it is.
    void wait_for(const voxel::BoxKey& key, BlockListener& listener, std::uint64_t ticket);
    /// No call reaches the listener after this, and nobody will look at what has come for it.
    /// @param ticket nullopt: of any
    void forget(const BlockListener& listener, std::optional<std::uint64_t> ticket = std::nullopt);
    /// Waits for the box; a hole once stop() was called. Not for threads that trace.
    [[nodiscard]] BlockPin get(const voxel::BoxKey& key);
    /// Boxes to load, the first first, while nobody waits for others, until three quarters of the
    /// memory are full. Replaces earlier ones.
    void prefetch(std::vector<voxel::BoxKey> keys);

    /// Boxes that could not be had are asked for again from now on: between pictures, each of which
    /// has one answer. What the world was asked before and says later that it cannot give is asked
    /// once more: somebody who no longer needs it may have asked long ago.
    void forget_holes();

    /// @throws voxel::ChangedError once a box could not be had for that. Such boxes are holes that
    /// are not told one by one: who makes something of the world asks here before it takes what has
    /// holes.
    void check_world() const;

    /// Nobody needs boxes any more: none is asked for, and requests under way end.
    void stop();

    [[nodiscard]] const voxel::WorldInfo& world_info() const noexcept { return m_world.info(); }
    [[nodiscard]] std::size_t limit_bytes() const noexcept { return m_limit_bytes; }
    [[nodiscard]] BlockStats stats() const;
    /// Boxes that could not be made or fetched so far.
    [[nodiscard]] std::size_t hole_count() const;
    /// Whether this box could not be made or fetched. Once it is so, it stays so until
    /// forget_holes().
    [[nodiscard]] bool is_hole(const voxel::BoxKey& key) const;

private:
    struct Wait {
        BlockListener* listener;
        std::uint64_t ticket;
    };
    struct Entry {
        BlockPin block;                            ///< nullptr while it is queued or being loaded
        std::list<voxel::BoxKey>::iterator place;  ///< in m_order, with a block only
        std::vector<Wait> waits;
        bool loading = false, wanted = false;
        int getters = 0;      ///< threads in get(); the entry stays while there are some
        bool unseen = false;  ///< came for somebody who has not looked yet
    };
    void load_boxes();
    [[nodiscard]] bool next_keys(std::vector<voxel::BoxKey>& keys);
    void take_wanted(std::size_t most, std::vector<voxel::BoxKey>& keys);
    void take_foreseen(std::size_t most, std::vector<voxel::BoxKey>& keys);
    [[nodiscard]] std::size_t share_of(std::size_t queued) const noexcept;
    [[nodiscard]] std::size_t coming_bytes(std::size_t more) const noexcept;
    [[nodiscard]] std::vector<voxel::BoxKey> load(const std::vector<voxel::BoxKey>& keys);
    /// @param failure none: it was a hole before, or nobody needs boxes any more
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
    const std::size_t m_batch;  ///< most boxes of one question
    const std::size_t m_loader_count;
    const std::size_t m_max_ahead;  ///< loaders that may ask for what nobody waits for
    std::array<voxel::BoxRange, voxel::kMaxLevel + 1> m_ranges;
    const BlockPin m_air = std::make_shared<const Block>();

    mutable std::mutex m_mutex;
    std::condition_variable m_work, m_came;
    std::unordered_map<voxel::BoxKey, Entry, voxel::BoxKeyHash> m_entries;
    std::list<voxel::BoxKey> m_order;  ///< least recently used last
    std::deque<voxel::BoxKey> m_wanted, m_foreseen;
    std::unordered_set<voxel::BoxKey, voxel::BoxKeyHash> m_loaded_once;
    BlockStats m_stats;
    std::size_t m_unseen_bytes = 0, m_freed_bytes = 0;
    std::size_t m_busy = 0;   ///< loaders that ask for boxes
    std::size_t m_ahead = 0;  ///< those of them that ask for what nobody waited for when they began
    std::size_t m_coming = 0;  ///< boxes that they have asked for
    bool m_stop = false;
    std::set<voxel::BoxKey> m_holes;
    std::uint64_t m_forgotten = 0;  ///< how often forget_holes() was called
    std::set<std::string> m_hole_reasons;
    std::exception_ptr m_changed;  ///< the first ChangedError
    std::vector<std::thread> m_loaders;
};

}  // namespace terravox::blocks
