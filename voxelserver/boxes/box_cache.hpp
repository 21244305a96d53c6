#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <thread>
#include <vector>

#include "common/util/cache.hpp"
#include "common/util/stage_times.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/boxes/admission_control.hpp"
#include "voxelserver/boxes/disk_cache.hpp"
#include "voxelserver/boxes/kept_box.hpp"

namespace terravox::boxes {

struct BoxCacheOptions {
    std::size_t memory_bytes = std::size_t{256} << 20;  ///< of compressed boxes
    int makers = 1;                                     ///< boxes made at the same time, at least 1
    int queue = 64;     ///< boxes that may wait to be made, at least 0
    int asking = 1024;  ///< callers of get() that may make or wait at the same time, at least 1
    /// Boxes above level 0 are made here of their eight children, so that children which are kept
    /// are not made again; otherwise the world makes those of every level.
    bool downsample = true;
    bool ahead = true;  ///< neighbours of what was asked for are made while the machine is idle
    std::filesystem::path file = {};  ///< of the disk cache; empty: nothing on disk
    std::uint64_t disk_bytes = std::uint64_t{20} << 30;
};

/// Boxes, each made once while it is kept, however many ask: memory, then disk, then making.
/// Thread-safe.
///
/// The world makes boxes of level 0, and those above, too, unless BoxCacheOptions::downsample.
/// Neighbours of a box that had to be made are made
/// ahead, by threads of their own.
class BoxCache {
public:
    /// World and times must outlive the cache.
    BoxCache(voxel::ProvenanceWorld& world, util::StageTimes& times,
             const BoxCacheOptions& options);
    ~BoxCache();
    BoxCache(const BoxCache&) = delete;
    BoxCache& operator=(const BoxCache&) = delete;

    /// @param key with a level of the world @return never nullptr
    /// @throws OverloadedError; Error (or whatever the world throws) when the box cannot be made
    [[nodiscard]] KeptBoxPtr get(const voxel::BoxKey& key);
    enum class Keep { kNo, kYes };
    /// What is kept: nothing is made. @param keep whether one from disk goes to memory: not for
    /// callers who look through many
    /// @return nullptr when it is not kept
    [[nodiscard]] KeptBoxPtr find(const voxel::BoxKey& key, Keep keep = Keep::kYes);
    /// As get(), when nobody waits for it: begins once the machine is idle. @return nullptr when
    /// the cache is being closed
    [[nodiscard]] KeptBoxPtr get_ahead(const voxel::BoxKey& key);
    /// The same unpacked. @return nullptr for air
    [[nodiscard]] static std::shared_ptr<const voxel::Box> unpacked(const KeptBox& kept,
                                                                    const voxel::BoxKey& key);

    /// Called with every box that has come to hand (made, or found on disk), once find() finds it.
    /// From any thread; to be set before anyone asks.
    void set_listener(std::function<void(const voxel::BoxKey&)> listener) {
        m_listener = std::move(listener);
    }

    /// For those who may wait for boxes in other ways than get().
    [[nodiscard]] Slots& places() noexcept { return m_places; }
    /// Whoever asks for what is not kept gets OverloadedError from now on, and so does whoever
    /// waits in line.
    void refuse() { m_gate.refuse(); }
    [[nodiscard]] bool refusing() const { return m_gate.refusing(); }

    /// Nothing is made ahead from now on; returns when what was under way is done. Idempotent.
    void close();

    struct Stats {
        util::CacheStats memory;
        AdmissionControl::Counts gate;
        std::size_t ahead_waiting = 0;
        std::uint64_t made = 0, made_ahead = 0, failed = 0;
    };
    [[nodiscard]] Stats stats() const;
    [[nodiscard]] std::size_t limit_bytes() const noexcept { return m_memory.limit_bytes(); }
    [[nodiscard]] std::vector<voxel::BoxKey> in_memory(int level, std::size_t most) const;
    [[nodiscard]] DiskCache* disk() const noexcept { return m_disk.get(); }  ///< nullptr: none
    [[nodiscard]] voxel::ProvenanceWorld& world() const noexcept { return m_world; }

private:
    void tell_threads_to_stop();
    /// Who is asking: a person or program, or a box above for its child: both stand in line;
    /// whoever works ahead has waited already.
    enum class Way { kAsked, kChild, kAhead };
    KeptBoxPtr get(const voxel::BoxKey& key, Way way);
    KeptBoxPtr make(const voxel::BoxKey& key, Way way);
    voxel::BoxWithInputs build(const voxel::BoxKey& key, Way way);
    [[nodiscard]] KeptBoxPtr known_air(const voxel::BoxKey& key) const;
    [[nodiscard]] KeptBoxPtr from_disk(const voxel::BoxKey& key);
    void want_ahead(const voxel::BoxKey& key);
    void work_ahead();

    voxel::ProvenanceWorld& m_world;
    util::StageTimes& m_times;
    AdmissionControl m_gate;
    Slots m_places;
    const bool m_downsample;
    const bool m_ahead_on;
    util::Cache<voxel::BoxKey, KeptBox, voxel::BoxKeyHash> m_memory;
    const std::unique_ptr<DiskCache> m_disk;
    std::function<void(const voxel::BoxKey&)> m_listener;
    std::atomic<std::uint64_t> m_made{0}, m_made_ahead{0}, m_failed{0};

    mutable std::mutex m_wanting;  ///< guards what follows
    std::condition_variable m_wanted;
    std::deque<voxel::BoxKey> m_ahead;  ///< wanted last first
    std::set<voxel::BoxKey> m_ahead_set;
    bool m_closed = false;
    std::mutex m_joining;  ///< held while threads are joined
    std::vector<std::thread> m_threads;
};

}  // namespace terravox::boxes
