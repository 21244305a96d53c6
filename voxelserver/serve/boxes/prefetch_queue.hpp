#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <set>
#include <vector>

#include "common/voxel/box.hpp"

namespace terravox::boxes {

/// Keys of boxes to prefetch, the most recently added first. Thread-safe.
///
/// Holds each key at most once, and a limited number of keys: the oldest are dropped. It has no
/// thread and no clock of its own. One lock guards all members.
class PrefetchQueue {
public:
    explicit PrefetchQueue(std::size_t max_keys) : m_max_keys(max_keys) {}

    /// Adds keys, the last one to be taken first; a key that is queued already keeps its place.
    /// Does nothing after close().
    /// @param wanted whether a key is to be added; called under the lock, and must not use the
    /// queue
    void add(const std::vector<voxel::BoxKey>& keys,
             const std::function<bool(const voxel::BoxKey&)>& wanted);
    /// Removes the first key; waits for one while the queue is empty.
    /// @return nullopt after close(), also when keys are left
    [[nodiscard]] std::optional<voxel::BoxKey> take();
    void close();  ///< ends the waiting in take(); idempotent
    [[nodiscard]] std::size_t size() const;

private:
    const std::size_t m_max_keys;
    mutable std::mutex m_mutex;  ///< guards the following members
    std::condition_variable m_changed;
    std::deque<voxel::BoxKey> m_keys;
    std::set<voxel::BoxKey> m_queued;  ///< the keys in m_keys
    bool m_closed = false;
};

}  // namespace terravox::boxes
