#pragma once

#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "common/voxel/world.hpp"
#include "voxelserver/data/store/grabber_store.hpp"
#include "voxelserver/make/voxelize/points/square_info.hpp"
#include "voxelserver/serve/http/squares.hpp"

namespace terravox::serve {

/// The squares shown by the HTTP interface: those of the world, and those that the store has not
/// fetched, where they can be placed in the world. Thread-safe.
class SquareList {
public:
    /// @param store must outlive the list; nullopt: the world is of plain files
    explicit SquareList(const std::optional<store::GrabberStore>& store) : m_store(store) {}
    /// @param world the same in each call: what is not fetched is placed in it once
    [[nodiscard]] std::vector<http::SquareEntry> entries(
        std::span<const voxelize::SquareInfo> opened, const voxel::WorldInfo& world);

private:
    const std::optional<store::GrabberStore>& m_store;
    std::once_flag m_once;
    std::vector<http::SquareEntry> m_unfetched;
};

}  // namespace terravox::serve
