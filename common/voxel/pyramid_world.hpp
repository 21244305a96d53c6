#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/util/cache.hpp"
#include "common/voxel/world.hpp"

namespace terravox::voxel {

/// A vertical stack of level-0 boxes on 64 x 64 columns, from by_begin up, without gaps; nullptr =
/// air.
struct FineColumn {
    std::int32_t by_begin = 0;
    std::vector<std::shared_ptr<const Box>> boxes;
};

/// The number of levels of a world with these bounds: the coarsest is the first that is at most one
/// box across.
[[nodiscard]] int levels_for(const VoxelBounds& bounds) noexcept;

/// @throws UsageError for a level that the world does not have
void check_level(const WorldInfo& world, int level);

/// The extent of a column of a world that may hold something everywhere: that of its bounds.
[[nodiscard]] ColumnExtent column_of_bounds(const VoxelBounds& bounds, int level, std::int32_t bx,
                                            std::int32_t bz) noexcept;

/// A world that generates its finest boxes, a whole column of boxes at a time, and derives those of
/// coarser levels by downsample(). All boxes are cached under a byte limit with LRU eviction; a box
/// requested by several threads at once is made once. Thread-safe.
class PyramidWorld : public World {
public:
    /// @throws UsageError for a level that the world does not have; Error as make_column
    [[nodiscard]] std::shared_ptr<const Box> box(const BoxKey& key) final;
    [[nodiscard]] ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override;
    [[nodiscard]] bool may_hold(const BoxRange& boxes) override;

protected:
    /// @param limit_bytes cache limit for all boxes
    explicit PyramidWorld(std::size_t limit_bytes)
        : m_fine(limit_bytes / 4 * 3), m_coarse(limit_bytes / 4) {}

    /// Makes the level-0 boxes of a column. Called by several threads at once, but by only one at a
    /// time for a given column.
    /// @throws Error when they cannot be made
    [[nodiscard]] virtual FineColumn make_column(std::int32_t bx, std::int32_t bz) = 0;
    /// Whether a column of boxes of a level may contain anything: cheap and conservative (may
    /// return true for an empty column). Called within the world's bounds only.
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
