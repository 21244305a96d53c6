#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/util/cache.hpp"
#include "common/voxel/world.hpp"
#include "raytracer/farm/net/farm.pb.h"

namespace terravox::farm {

/// Packed boxes that coordinators have sent, kept by the daemon from one link to the next.
/// Thread-safe.
class BoxShelf {
public:
    /// @param max_worlds number of worlds whose boxes are kept: each coordinator numbers its worlds
    /// itself, and most never return
    BoxShelf(std::size_t memory_bytes, std::size_t max_worlds)
        : m_frames(memory_bytes), m_max_worlds(max_worlds) {}
    /// Marks a world as in use; where there are too many, the boxes of the least recently used
    /// world are dropped.
    void open(std::uint64_t world_id);
    struct Key {
        std::uint64_t world_id;
        voxel::BoxKey box;
        friend bool operator==(const Key&, const Key&) = default;
    };
    struct Hash {
        std::size_t operator()(const Key& key) const noexcept {
            return voxel::BoxKeyHash()(key.box) ^ key.world_id * 0x9e3779b97f4a7c15U;
        }
    };
    /// Empty: air.
    using Frame = std::vector<std::byte>;
    [[nodiscard]] std::shared_ptr<const Frame> find(const Key& key) { return m_frames.find(key); }
    void put(const Key& key, std::shared_ptr<const Frame> frame) {
        const std::size_t bytes = frame->size();
        m_frames.put(key, frame, bytes);
    }

private:
    util::Cache<Key, Frame, Hash> m_frames;
    const std::size_t m_max_worlds;
    std::mutex m_mutex;
    std::deque<std::uint64_t> m_worlds;  ///< the latest first
};

/// A world whose boxes the coordinator sends. Thread-safe: requesting threads block until the
/// link's reader delivers the reply.
class CoordinatorWorld final : public voxel::World {
public:
    /// @param send sends a frame to the coordinator; false: the link has ended
    CoordinatorWorld(voxel::WorldInfo info, std::uint64_t world_id,
                     std::function<bool(farm::Frame)> send, BoxShelf& shelf);

    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_info; }
    [[nodiscard]] std::shared_ptr<const voxel::Box> box(const voxel::BoxKey& key) override;
    void boxes(std::span<const voxel::BoxKey> keys, const voxel::TakeBox& take) override;
    [[nodiscard]] int preferred_batch() const noexcept override { return 32; }
    [[nodiscard]] int useful_concurrency(int threads) const noexcept override {
        return std::max(threads, 8);
    }
    /// All boxes of the world's full vertical range; no request is sent.
    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override;
    void stop() noexcept override;

    /// Accepts a reply of the coordinator.
    /// @return false: it was not requested
    [[nodiscard]] bool on_reply(const farm::BoxReply& reply);
    [[nodiscard]] std::uint64_t world_id() const noexcept { return m_world_id; }

private:
    struct PendingBox {
        int waiting = 0;  ///< threads
        bool here = false;
        std::shared_ptr<const BoxShelf::Frame> frame;  ///< nullptr when the box was not available
        std::string hole;
    };
    [[nodiscard]] std::shared_ptr<const voxel::Box> unpacked(const voxel::BoxKey& key,
                                                             const BoxShelf::Frame& frame) const;

    const voxel::WorldInfo m_info;
    const std::uint64_t m_world_id;
    const std::function<bool(farm::Frame)> m_send;
    BoxShelf& m_shelf;
    std::mutex m_mutex;
    std::condition_variable m_replied;
    std::unordered_map<voxel::BoxKey, std::shared_ptr<PendingBox>, voxel::BoxKeyHash> m_pending;
    bool m_stop = false;
};

/// A world that requests from another one the boxes that it cannot get itself, so that a picture
/// does not depend on which machine computed it.
class FallbackWorld final : public voxel::World {
public:
    FallbackWorld(std::unique_ptr<voxel::World> own, voxel::World& helper)
        : m_own(std::move(own)), m_helper(helper) {}
    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_own->info(); }
    [[nodiscard]] std::shared_ptr<const voxel::Box> box(const voxel::BoxKey& key) override;
    void boxes(std::span<const voxel::BoxKey> keys, const voxel::TakeBox& take) override;
    [[nodiscard]] int preferred_batch() const noexcept override { return m_own->preferred_batch(); }
    [[nodiscard]] int useful_concurrency(int threads) const noexcept override {
        return m_own->useful_concurrency(threads);
    }
    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override {
        return m_own->column(level, bx, bz);
    }
    void stop() noexcept override {
        m_own->stop();
        m_helper.stop();
    }

private:
    std::unique_ptr<voxel::World> m_own;
    voxel::World& m_helper;
};

}  // namespace terravox::farm
