#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "common/voxel/world.hpp"

namespace terravox::blocks {

/// A box as the walker meets it. A hole is a box that could not be made or fetched: it is shown and
/// counted, never treated as air.
struct Block {
    std::shared_ptr<const voxel::Box> box;  ///< nullptr: air, or a hole
    bool hole = false;
    /// Bricks whose `first` is less than this are full of equal voxels: see packed().
    std::uint32_t shared_attrs = 0;
    [[nodiscard]] std::size_t memory_bytes() const noexcept {
        return kOverhead_bytes + (box ? box->memory_bytes() : 0);
    }
    /// Bytes of an entry and its place in maps and lists.
    static constexpr std::size_t kOverhead_bytes = 256;
};
/// Keeps its box in memory while it exists: the box is not evicted.
using BlockPin = std::shared_ptr<const Block>;

/// Notified when boxes that it waits for have arrived.
class BlockListener {
public:
    virtual ~BlockListener() = default;
    /// Called once for each wait, from any thread and with the manager's lock held: it must be
    /// short and must not call the manager.
    /// @return whether the box will be read by the waiting side; it stays in memory until then
    virtual bool on_block_loaded(const voxel::BoxKey& key, std::uint64_t ticket) noexcept = 0;
};

}  // namespace terravox::blocks
