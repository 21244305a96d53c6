#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "common/voxel/box.hpp"
#include "raytracer/core/blocks/block.hpp"

namespace terravox::blocks {

/// The boxes that could not be made or fetched, and why. Each is counted once, and stays a hole
/// until it is forgotten. Not thread-safe: the block manager uses it under its lock.
class HoleRecord {
public:
    /// Records a hole and logs its reason, unless the same reason has been logged before. A box
    /// that failed with voxel::ChangedError is not logged; the first such error is kept.
    /// @param failure not null
    void add(const voxel::BoxKey& key, const std::exception_ptr& failure);
    [[nodiscard]] bool contains(const voxel::BoxKey& key) const { return m_holes.contains(key); }
    [[nodiscard]] std::size_t size() const noexcept { return m_holes.size(); }
    /// Forgets the holes for which may_forget(key) is true, and begins a new generation.
    void forget(const std::function<bool(const voxel::BoxKey&)>& may_forget);
    /// Number of calls of forget() so far.
    [[nodiscard]] std::uint64_t generation() const noexcept { return m_generation; }
    /// @throws voxel::ChangedError the first one that was added, also after forget()
    void check_world() const;

private:
    std::set<voxel::BoxKey> m_holes;
    std::set<std::string> m_reasons;  ///< those that were logged
    std::exception_ptr m_changed;     ///< the first ChangedError
    std::uint64_t m_generation = 0;
};

/// Decides which boxes a loader requests from the world next: those with a waiter in the order of
/// their waits, then prefetched ones. It has no lock, no thread and no clock, and loads nothing.
/// Not thread-safe: the block manager uses it under its lock.
///
/// What is queued is shared among the idle loaders, up to a batch for each. Where batches are
/// larger than one box, a quarter of the loaders is reserved for boxes with a waiter: such a box
/// must not be queued behind whole batches of others. A request may fill a quarter of the memory
/// with unread boxes for waiters, and prefetching stops at three quarters of the memory; but
/// the first box of a request is taken without regard to its own size, or none would ever be
/// loaded.
class LoadQueue {
public:
    struct Limits {
        std::size_t memory_bytes = 0;  ///< of all boxes in memory
        std::size_t batch = 1;         ///< greatest number of boxes of a request, at least 1
        std::size_t loaders = 1;       ///< at least 1
    };
    /// Boxes that one loader requests from the world together.
    struct Request {
        std::vector<voxel::BoxKey> keys;
        bool prefetched = false;  ///< whether none of them had a waiter when they were taken
    };
    using Predicate = std::function<bool(const voxel::BoxKey&)>;

    explicit LoadQueue(const Limits& limits) noexcept;

    [[nodiscard]] std::size_t loader_count() const noexcept { return m_limits.loaders; }

    /// Queues a box that has a waiter. The caller makes sure that it is neither queued here nor
    /// being loaded.
    void add_requested(const voxel::BoxKey& key) { m_requested.push_back(key); }
    /// Removes the boxes with a waiter for which drop(key) is true.
    void drop_requested(const Predicate& drop) { std::erase_if(m_requested, drop); }
    /// Replaces the boxes to prefetch. Any of them may be loaded already.
    void replace_prefetched(const std::vector<voxel::BoxKey>& keys) {
        m_prefetched.assign(keys.begin(), keys.end());
    }

    /// Takes the boxes of the next request off the queue. Called for an idle loader, which is busy
    /// from then on until finish(), and each of the boxes is under way until on_box_loaded().
    /// @param is_known whether a box is in memory, has a waiter or is being loaded; such a box is
    ///        not prefetched
    /// @param request its former keys are replaced
    /// @return false if there is nothing to load now; the request has no keys then
    [[nodiscard]] bool take(const MemoryUse& memory, const Predicate& is_known, Request& request);
    /// Called once for each box of a request, when it has arrived or has become a hole.
    void on_box_loaded() noexcept { --m_boxes_under_way; }
    /// Called once for each request that was taken, when its loader is idle again.
    void finish(const Request& request) noexcept;

private:
    [[nodiscard]] std::size_t measure_share(std::size_t queued) const noexcept;
    [[nodiscard]] std::size_t expected_bytes(const MemoryUse& memory,
                                             std::size_t more) const noexcept;
    void take_requested(const MemoryUse& memory, std::vector<voxel::BoxKey>& keys);
    void take_prefetched(const MemoryUse& memory, const Predicate& is_known,
                         std::vector<voxel::BoxKey>& keys);

    const Limits m_limits;
    const std::size_t m_max_prefetching;  ///< loaders that may request boxes without a waiter
    std::deque<voxel::BoxKey> m_requested;
    std::deque<voxel::BoxKey> m_prefetched;
    std::size_t m_busy = 0;         ///< loaders with a request under way
    std::size_t m_prefetching = 0;  ///< those of them whose boxes had no waiter when they began
    std::size_t m_boxes_under_way = 0;
};

}  // namespace terravox::blocks
