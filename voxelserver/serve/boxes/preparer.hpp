#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "voxelserver/serve/boxes/box_cache.hpp"

namespace terravox::boxes {

/// Enumerates all boxes of a world, children before their parents and neighbours close together,
/// without holding them in memory.
class BoxTraversal {
public:
    explicit BoxTraversal(voxel::World& world);
    /// @return false at the end
    /// @throws Error as World::column
    [[nodiscard]] bool next(voxel::BoxKey& key);
    [[nodiscard]] static std::uint64_t count(voxel::World& world);

private:
    struct Node {
        int level = 0;
        std::int32_t bx = 0;
        std::int32_t bz = 0;
        bool opened = false;  ///< its children have been enumerated
    };
    void push(int level, std::int32_t bx, std::int32_t bz) {
        m_open.push_back({level, bx, bz, false});
    }
    voxel::World& m_world;
    std::vector<Node> m_open;  ///< depth-first stack; the next node is the last
    voxel::BoxKey m_current;   ///< next box of the current column
    std::int32_t m_by_end = 0;
};

/// Makes all boxes of a world in advance, on threads of its own, only while no other request for a
/// box is pending. Thread-safe.
class Preparer {
public:
    struct Progress {
        std::uint64_t done = 0, total = 0, failed = 0;  ///< `done` includes the failed ones
    };

    /// Starts the threads.
    /// @param lanes number of boxes made in parallel
    /// @param failed called with the message of each failure, from any thread, one call at a time
    Preparer(BoxCache& cache, int lanes, std::function<void(const std::string&)> failed);
    ~Preparer();  ///< stops after the boxes in progress
    Preparer(const Preparer&) = delete;
    Preparer& operator=(const Preparer&) = delete;

    [[nodiscard]] Progress progress() const noexcept { return {m_done, m_total, m_failed}; }
    [[nodiscard]] bool finished() const noexcept { return m_running == 0; }
    void stop() noexcept { m_stop = true; }

private:
    void work();
    [[nodiscard]] bool make(const voxel::BoxKey& key);  ///< false when stopped
    BoxCache& m_cache;
    std::function<void(const std::string&)> m_on_failure;
    std::mutex m_mutex;  ///< guards m_walk and m_on_failure
    BoxTraversal m_walk;
    std::atomic<std::uint64_t> m_done{0};
    std::atomic<std::uint64_t> m_failed{0};
    std::once_flag m_counted;
    std::atomic<std::uint64_t> m_total{0};  ///< 0 until counting has finished
    std::atomic<bool> m_stop{false};
    std::atomic<int> m_running;
    std::vector<std::thread> m_lanes;
};

}  // namespace terravox::boxes
