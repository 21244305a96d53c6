#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "voxelserver/boxes/box_cache.hpp"

namespace terravox::boxes {

/// All boxes of a world, children before their parents and neighbours close together, without
/// holding them in memory.
class BoxWalk {
public:
    explicit BoxWalk(voxel::World& world);
    [[nodiscard]] bool next(
        voxel::BoxKey& key);  ///< false at the end @throws Error as World::column
    [[nodiscard]] static std::uint64_t count(voxel::World& world);

private:
    struct Node {
        int level = 0;
        std::int32_t bx = 0, bz = 0;
        bool opened = false;  ///< its children are done
    };
    void push(int level, std::int32_t bx, std::int32_t bz) {
        m_open.push_back({level, bx, bz, false});
    }
    voxel::World& m_world;
    std::vector<Node> m_open;  ///< depth first, next one last
    voxel::BoxKey m_current;   ///< next box of the column that is being given out
    std::int32_t m_by_end = 0;
};

/// Makes all boxes of a world ahead of need, on threads of its own: only while nobody waits for
/// another box. Thread-safe.
class Preparer {
public:
    struct Progress {
        std::uint64_t done = 0, total = 0, failed = 0;  ///< failed ones are among the done
    };

    /// Starts. @param lanes boxes at the same time  @param failed called with each failure, from
    /// any lane, one at a time
    Preparer(BoxCache& cache, int lanes, std::function<void(const std::string&)> failed);
    ~Preparer();  ///< stops after the boxes under way
    Preparer(const Preparer&) = delete;
    Preparer& operator=(const Preparer&) = delete;

    [[nodiscard]] Progress progress() const noexcept { return {m_done, m_total, m_failed}; }
    [[nodiscard]] bool finished() const noexcept { return m_running == 0; }
    void stop() noexcept { m_stop = true; }

private:
    void work();
    [[nodiscard]] bool make(const voxel::BoxKey& key);  ///< false: stopped
    BoxCache& m_cache;
    std::function<void(const std::string&)> m_on_failure;
    std::mutex m_mutex;  ///< guards m_walk and m_on_failure
    BoxWalk m_walk;
    std::atomic<std::uint64_t> m_done{0}, m_failed{0};
    std::once_flag m_counted;
    std::atomic<std::uint64_t> m_total{0};  ///< 0 until it is counted
    std::atomic<bool> m_stop{false};
    std::atomic<int> m_running;
    std::vector<std::thread> m_lanes;
};

}  // namespace terravox::boxes
