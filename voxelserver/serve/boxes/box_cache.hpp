#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "common/util/cache.hpp"
#include "common/util/stage_times.hpp"
#include "common/voxel/box.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/serve/boxes/admission_control.hpp"
#include "voxelserver/serve/boxes/disk_cache.hpp"

namespace terravox::boxes {

/// A box in the form in which it is cached and sent.
struct CompressedBox {
    std::uint64_t checksum = 0;  ///< checksum of the box (Box::checksum); 0 for air
    /// Hash of the frame's bytes, which may differ between versions of zstd.
    std::uint64_t frame_hash = 0;
    /// The zstd frame of the box's blob; nullptr: known to be air.
    std::shared_ptr<const std::string> frame;
    voxel::InputExtent reach;  ///< extent of all inputs that affected it

    [[nodiscard]] bool air() const noexcept { return frame == nullptr; }
    [[nodiscard]] std::size_t memory_bytes() const noexcept {
        return sizeof *this + (frame ? sizeof *frame + frame->capacity() : 0);
    }
};
using CompressedBoxPtr = std::shared_ptr<const CompressedBox>;  ///< never nullptr unless documented

/// The box columns of level 0 that a box covers.
/// @return saturated for keys that are outside of any possible world
[[nodiscard]] inline voxel::InputExtent footprint(const voxel::BoxKey& key) noexcept {
    const auto scaled = [&](std::int64_t value) {
        constexpr std::int64_t kFarthest = std::int64_t{1} << 30;
        const std::int64_t out = value * (std::int64_t{1} << key.level);
        return static_cast<std::int32_t>(out < -kFarthest  ? -kFarthest
                                         : out > kFarthest ? kFarthest
                                                           : out);
    };
    return {scaled(key.bx), scaled(key.bz), scaled(std::int64_t{key.bx} + 1),
            scaled(std::int64_t{key.bz} + 1)};
}

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

struct BoxCacheOptions {
    std::size_t memory_bytes = std::size_t{256} << 20;  ///< limit for compressed boxes
    int makers = 1;                                     ///< boxes made in parallel, at least 1
    int queue = 64;           ///< boxes that may wait to be made, at least 0
    int max_requests = 1024;  ///< calls that may make a box or wait for one, at least 1
    /// Whether the cache makes boxes above level 0 from their eight children, so that cached
    /// children are not made again; otherwise the world makes the boxes of every level.
    bool downsample = true;
    /// Whether neighbours of requested boxes are prefetched while the machine is idle.
    bool ahead = true;
    std::filesystem::path file = {};  ///< disk cache; empty: no disk cache
    std::uint64_t disk_bytes = std::uint64_t{20} << 30;
};

/// A cache of boxes in memory and on disk. A box that is in neither is made once, however many
/// threads request it. Thread-safe.
///
/// The world makes boxes of level 0, and those of coarser levels as well unless
/// BoxCacheOptions::downsample is set. After a requested box was made, its neighbours are
/// prefetched by separate threads.
class BoxCache {
public:
    /// @param world, times must outlive the cache
    BoxCache(voxel::ProvenanceWorld& world, util::StageTimes& times,
             const BoxCacheOptions& options);
    ~BoxCache();
    BoxCache(const BoxCache&) = delete;
    BoxCache& operator=(const BoxCache&) = delete;

    /// @param key with a level of the world
    /// @return never nullptr
    /// @throws OverloadedError; Error (or any other exception of the world) when the box cannot be
    /// made
    [[nodiscard]] CompressedBoxPtr find_or_make(const voxel::BoxKey& key);
    /// As find_or_make(), but with low priority: starts when the machine is idle.
    /// @return nullptr when the cache is being closed
    [[nodiscard]] CompressedBoxPtr find_or_make_when_idle(const voxel::BoxKey& key);
    /// Looks a box up in memory and on disk; makes nothing.
    /// @return nullptr when it is not cached
    [[nodiscard]] CompressedBoxPtr find(const voxel::BoxKey& key);
    /// As find(), but a box read from disk is not put into memory: for callers that scan many.
    [[nodiscard]] CompressedBoxPtr peek(const voxel::BoxKey& key);
    /// @return nullptr for air
    [[nodiscard]] static std::shared_ptr<const voxel::Box> decompress(const CompressedBox& box,
                                                                      const voxel::BoxKey& key);

    /// Sets a function that is called for every box that has become available (made, or read from
    /// disk), after find() can find it. It is called from any thread. Must be set before the first
    /// request.
    void set_listener(std::function<void(const voxel::BoxKey&)> listener) {
        m_listener = std::move(listener);
    }

    /// The slots for waiting requests, for callers that may wait for boxes by other means than
    /// find_or_make().
    [[nodiscard]] Slots& slots() noexcept { return m_slots; }
    /// From now on, requests for boxes that are not cached, and requests that wait in the queue,
    /// fail with OverloadedError.
    void refuse() { m_admission.refuse(); }
    [[nodiscard]] bool refusing() const { return m_admission.refusing(); }

    /// Stops prefetching; returns when the boxes in progress are finished. Idempotent.
    void close();

    struct Stats {
        util::CacheStats memory;
        AdmissionControl::Counts admission;
        std::size_t ahead_waiting = 0;
        std::uint64_t made = 0;
        std::uint64_t made_ahead = 0;
        std::uint64_t failed = 0;
    };
    [[nodiscard]] Stats stats() const;
    /// BoxCacheOptions::downsample.
    [[nodiscard]] bool makes_coarse_from_fine() const noexcept { return m_downsample; }
    [[nodiscard]] std::size_t limit_bytes() const noexcept { return m_memory.limit_bytes(); }
    [[nodiscard]] std::vector<voxel::BoxKey> in_memory(int level, std::size_t max_keys) const;
    /// nullptr: no disk cache.
    [[nodiscard]] DiskCache* disk() const noexcept { return m_disk.get(); }
    [[nodiscard]] voxel::ProvenanceWorld& world() const noexcept { return m_world; }

private:
    void request_stop();
    /// Origin of a request: an external caller, a parent box that needs a child, or prefetching.
    /// The first two wait in the queue; prefetching holds a PrefetchPermit already.
    enum class Origin { kCaller, kParent, kPrefetch };
    CompressedBoxPtr find_or_make(const voxel::BoxKey& key, Origin origin);
    /// Waits until it may be made, makes it, counts it and has it written to disk.
    CompressedBoxPtr make_and_store(const voxel::BoxKey& key, Origin origin);
    CompressedBoxPtr make_compressed(const voxel::BoxKey& key, Origin origin);
    voxel::BoxWithInputs make_box(const voxel::BoxKey& key, Origin origin);
    [[nodiscard]] CompressedBoxPtr find_in_memory(const voxel::BoxKey& key);
    /// @return nullptr for a box within the bounds of the world
    [[nodiscard]] CompressedBoxPtr air_outside_bounds(const voxel::BoxKey& key) const;
    [[nodiscard]] CompressedBoxPtr read_from_disk(const voxel::BoxKey& key);
    void queue_neighbours(const voxel::BoxKey& key);
    void prefetch_queued();

    voxel::ProvenanceWorld& m_world;
    util::StageTimes& m_times;
    AdmissionControl m_admission;
    Slots m_slots;
    const bool m_downsample;
    const bool m_ahead_on;
    util::Cache<voxel::BoxKey, CompressedBox, voxel::BoxKeyHash> m_memory;
    const std::unique_ptr<DiskCache> m_disk;
    std::function<void(const voxel::BoxKey&)> m_listener;
    std::atomic<std::uint64_t> m_made{0};
    std::atomic<std::uint64_t> m_made_ahead{0};
    std::atomic<std::uint64_t> m_failed{0};

    PrefetchQueue m_prefetch_queue;
    std::mutex m_join_mutex;  ///< held while threads are joined
    std::vector<std::thread> m_threads;
};

}  // namespace terravox::boxes
