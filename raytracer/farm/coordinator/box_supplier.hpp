#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "common/util/cache.hpp"
#include "raytracer/blocks/block_manager.hpp"
#include "raytracer/farm/net/farm.pb.h"

namespace terravox::farm {

/// Boxes for workers that cannot read the world themselves: packed once, kept packed while there is
/// room, and sent on request.
///
/// Requests wait in one queue for each asker. The queues are served in turn, so that none starves;
/// an asker whose link is slow waits until some of its data has gone out. Thread-safe; one lock,
/// not held while a box is made or sent.
class BoxSupplier {
public:
    /// How to reach an asker. Called on threads of the supplier.
    struct Way {
        std::function<bool(farm::Frame)> send;  ///< false: the asker is gone
        std::function<std::uint64_t()> queued_bytes = [] {
            return std::uint64_t{0};
        };  ///< sent, and not gone out yet
    };
    /// @param memory_bytes for packed boxes
    BoxSupplier(blocks::BlockManager& blocks, std::uint64_t world_id, std::size_t memory_bytes,
                int threads);
    ~BoxSupplier();
    BoxSupplier(const BoxSupplier&) = delete;
    BoxSupplier& operator=(const BoxSupplier&) = delete;

    /// @param asker a unique number of the asker
    /// @return false if it requests more than is allowed at once, or boxes of another world
    [[nodiscard]] bool ask(std::uint64_t asker, const farm::BoxRequest& request, const Way& way);
    /// Nothing is sent to the asker after this returns.
    void forget(std::uint64_t asker);
    [[nodiscard]] std::uint64_t world_id() const noexcept { return m_world_id; }
    [[nodiscard]] const blocks::BlockManager& blocks() const noexcept { return m_blocks; }
    static constexpr std::size_t kMaxWaiting = 65'536;  ///< keys per asker

private:
    void stop();
    struct Packed {
        std::vector<std::byte> frame;
        bool air = false;
    };
    struct Asker {
        std::uint64_t id;
        Way way;
        std::deque<voxel::BoxKey> keys;
        int serving = 0;
    };
    using Askers = std::deque<std::shared_ptr<Asker>>;
    void serve();
    [[nodiscard]] Askers::iterator next(std::unique_lock<std::mutex>& lock);
    /// @return nullptr: the box is a hole
    [[nodiscard]] std::shared_ptr<const Packed> packed(const voxel::BoxKey& key);

    blocks::BlockManager& m_blocks;
    const std::uint64_t m_world_id;
    util::Cache<voxel::BoxKey, Packed, voxel::BoxKeyHash> m_packed;
    std::mutex m_mutex;
    std::condition_variable m_work, m_idle;
    Askers m_askers;
    bool m_stop = false;
    std::vector<std::thread> m_threads;
};

}  // namespace terravox::farm
