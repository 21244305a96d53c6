#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/util/cache.hpp"
#include "common/voxel/world.hpp"

namespace terravox::voxel {

/// The finest boxes above each other on 64 x 64 columns, from by_begin up, without gaps; nullptr =
/// air.
struct FineColumn {
    std::int32_t by_begin = 0;
    std::vector<std::shared_ptr<const Box>> boxes;
};

/// How many levels a world of these bounds has, until it fits into one box across.
[[nodiscard]] int levels_for(const VoxelBounds& bounds) noexcept;

/// A world that makes its finest boxes, all of a column of boxes at once. Those of the levels above
/// are made from them by downsample(); all are kept under a byte limit, least recently used first
/// to go, and made once however many ask. Thread-safe.
class PyramidWorld : public World {
public:
    /// @throws UsageError for a level that the world does not have; Error as make_column
    [[nodiscard]] std::shared_ptr<const Box> box(const BoxKey& key) final;
    [[nodiscard]] ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override;
    [[nodiscard]] bool may_hold(const BoxRange& boxes) override;

protected:
    /// @param limit_bytes of the boxes that are kept
    explicit PyramidWorld(std::size_t limit_bytes)
        : m_fine(limit_bytes / 4 * 3), m_coarse(limit_bytes / 4) {}

    /// Makes the boxes of level 0 of a column. Called by several threads at once, for a column by
    /// one. @throws Error when they cannot be made
    [[nodiscard]] virtual FineColumn make_column(std::int32_t bx, std::int32_t bz) = 0;
    /// Whether anything may lie in a column of boxes of a level: a cheap answer that may say yes
    /// too often. Within the world's bounds only.
    [[nodiscard]] virtual bool may_hold_column(int /*level*/, std::int32_t /*bx*/,
                                               std::int32_t /*bz*/) const {
        return true;
    }

private:
    [[nodiscard]] std::shared_ptr<const Box> fine_box(const BoxKey& key);
    [[nodiscard]] std::shared_ptr<const Box> coarse_box(const BoxKey& key);
    util::Cache<BoxKey, FineColumn, BoxKeyHash> m_fine;  ///< by = 0
    util::Cache<BoxKey, Box, BoxKeyHash> m_coarse;
};

}  // namespace terravox::voxel
