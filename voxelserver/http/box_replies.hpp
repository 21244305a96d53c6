#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>

#include "common/util/cache.hpp"
#include "common/util/error.hpp"
#include "common/util/stage_times.hpp"
#include "common/voxel/world.hpp"

namespace terravox::http {

/// More boxes are asked for than can be made soon: ask again later.
class Busy : public Error {
public:
    using Error::Error;
};

/// Lets a few in at a time and a limited number wait in line; further ones are turned away at once. Thread-safe.
///
/// One lock guards two counters. It is never held while the work inside the gate runs.
class Gate {
public:
    Gate(int inside, int waiting) : m_most_inside(inside), m_most_waiting(waiting) {}

    class Pass {
    public:
        explicit Pass(Gate& gate) : m_gate(gate) { m_gate.enter(); }  ///< @throws Busy when the line is full
        ~Pass() { m_gate.leave(); }
        Pass(const Pass&) = delete;
        Pass& operator=(const Pass&) = delete;

    private:
        Gate& m_gate;
    };

private:
    void enter();
    void leave() noexcept;
    const int m_most_inside, m_most_waiting;
    std::mutex m_mutex;
    std::condition_variable m_left;
    int m_inside = 0, m_waiting = 0;
};

/// A box as it is sent.
struct BoxReply {
    std::string etag;                          ///< strong, with its quotes
    std::shared_ptr<const std::string> frame;  ///< zstd frame of the box's blob; nullptr: known to be air
};

struct BoxRepliesOptions {
    std::size_t memory_bytes = std::size_t{256} << 20;  ///< of compressed boxes
    int makers = 1;                                     ///< boxes made at the same time, at least 1
    int queue = 64;                                     ///< boxes that may wait to be made, at least 0
};

/// Makes, compresses and keeps the replies for boxes: each box once while it is kept, however many ask. Thread-safe.
class BoxReplies {
public:
    BoxReplies(voxel::World& world, util::StageTimes& times, const BoxRepliesOptions& options);

    /// @param key with a level of the world @return never nullptr
    /// @throws Busy; Error (or whatever the world throws) when the box cannot be made
    [[nodiscard]] std::shared_ptr<const BoxReply> get(const voxel::BoxKey& key);

    [[nodiscard]] util::CacheStats stats() const { return m_cache.stats(); }
    [[nodiscard]] std::size_t limit_bytes() const noexcept { return m_cache.limit_bytes(); }

private:
    std::shared_ptr<const BoxReply> make(const voxel::BoxKey& key);

    voxel::World& m_world;
    util::StageTimes& m_times;
    Gate m_gate;
    const std::shared_ptr<const BoxReply> m_air;
    util::Cache<voxel::BoxKey, BoxReply, voxel::BoxKeyHash> m_cache;
};

}  // namespace terravox::http
