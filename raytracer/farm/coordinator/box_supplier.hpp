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
#include "raytracer/core/blocks/block_manager.hpp"
#include "raytracer/farm/net/farm.pb.h"

namespace terravox::farm {

/// Boxes for workers that cannot read the world themselves: packed once, kept packed while there is
/// room, and sent on request.
///
/// Requests wait in one queue for each requester. The queues are served in turn, so that none
/// starves; a requester whose link is slow waits until some of its data has gone out. Thread-safe;
/// one lock, not held while a box is made or sent.
class BoxSupplier {
public:
    /// The way back to a requester. Called on threads of the supplier.
    struct ReplyChannel {
        /// @return false: the link has ended
        std::function<bool(farm::Frame)> send;
        /// Bytes that are queued for the link and not transmitted yet.
        std::function<std::uint64_t()> queued_bytes = [] { return std::uint64_t{0}; };
    };
    /// @param memory_bytes for packed boxes
    BoxSupplier(blocks::BlockManager& blocks, std::uint64_t world_id, std::size_t memory_bytes,
                int threads);
    ~BoxSupplier();

    /// @param requester a unique number of the requester
    /// @return false if it requests more than is allowed at once, or boxes of another world
    [[nodiscard]] bool request(std::uint64_t requester, const farm::BoxRequest& boxes,
                               const ReplyChannel& channel);
    /// Nothing is sent to the requester after this returns.
    void forget(std::uint64_t requester);
    [[nodiscard]] std::uint64_t world_id() const noexcept { return m_world_id; }
    [[nodiscard]] const blocks::BlockManager& blocks() const noexcept { return m_blocks; }
    static constexpr std::size_t kMaxWaiting = 65'536;  ///< keys per requester

private:
    void stop();
    struct Packed {
        std::vector<std::byte> frame;
        bool air = false;
    };
    struct Requester {
        std::uint64_t id;
        ReplyChannel channel;
        std::deque<voxel::BoxKey> keys;
        int serving = 0;
    };
    using Requesters = std::deque<std::shared_ptr<Requester>>;
    void serve();
    [[nodiscard]] Requesters::iterator next(std::unique_lock<std::mutex>& lock);
    /// @return nullptr: the box is a hole
    [[nodiscard]] std::shared_ptr<const Packed> packed(const voxel::BoxKey& key);

    blocks::BlockManager& m_blocks;
    const std::uint64_t m_world_id;
    util::Cache<voxel::BoxKey, Packed, voxel::BoxKeyHash> m_packed;
    std::mutex m_mutex;
    std::condition_variable m_work;
    std::condition_variable m_idle;
    Requesters m_requesters;
    bool m_stop = false;
    std::vector<std::thread> m_threads;
};

}  // namespace terravox::farm
