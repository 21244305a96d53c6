#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/voxel/world.hpp"
#include "voxelserver/data/water/evidence.hpp"
#include "voxelserver/data/water/water_cells.hpp"

namespace terravox::water {

/// An extent larger than any world.
inline constexpr voxel::InputExtent kAnywhere{-(1 << 26), -(1 << 26), 1 << 26, 1 << 26};

struct WaterOptions {
    int cell_voxels = 2;   ///< edge of a cell; a divisor of 64
    double voxel_m = 1;    ///< above 0
    bool equalize = true;  ///< false: each cell keeps its measured level (body_levels.hpp)
    Evidence evidence;     ///< criteria for water
    /// A body that touches more patches than this is divided along the lines of a fixed grid of
    /// squares of at most this many patches. An exploration holds the cells of that many patches in
    /// memory: 16 bytes per cell, 256 MB for cells of 2 voxels. At least 16.
    std::size_t max_body_patches = 16384;
    /// Memory limit for cached levels; when it is exceeded, the whole cache is cleared, and levels
    /// are recomputed on demand. A single body may exceed it.
    std::size_t memory_bytes = std::size_t{512} << 20;
};

/// Finds a water body when one of its cells is first requested, and caches its levels.
///
/// Results depend neither on the order of requests nor on threads: a body is collected completely,
/// its cells are sorted, then levels are computed. Thread-safe. Dry cells (all cells that are not
/// candidates, see evidence.hpp) cost one call of the source and load no other patch: request only
/// the cells that are needed, since exploring one body may read many patches. Bodies that fit in
/// nine patches, which includes nearly every void, are explored without a lock; larger ones one
/// after the other, while other threads continue with cells that are dry, in small bodies or
/// cached. The source must not call back. Memory: 4 bytes per cell in patches with water, 2 bytes
/// per cell in patches with any explored candidate, about 200 bytes each. Exceptions of the source
/// are passed on; nothing is cached of that exploration.
class WaterBodies {
public:
    /// @throws Error for an option out of range
    WaterBodies(CellSource& source, const WaterOptions& options);
    ~WaterBodies();
    WaterBodies(const WaterBodies&) = delete;
    WaterBodies& operator=(const WaterBodies&) = delete;

    /// @param cx, cz cell index: columns [cx, cx + 1) * cell_voxels, and so on
    /// @param reach grows by the patches that the answer depends on, whether or not it was cached:
    /// those of all candidates connected with the cell, and those adjacent to them. Whether a body
    /// is large enough to be divided depends on all of it: then it becomes kAnywhere. May be null
    /// @return voxels; NaN where there is no water
    [[nodiscard]] float level(std::int32_t cx, std::int32_t cz,
                              voxel::InputExtent* reach = nullptr);
    /// Like level(); where there is no water, the level of one of the eight neighbouring cells
    /// (edges before corners, west, east, north, south).
    [[nodiscard]] float level_near(std::int32_t cx, std::int32_t cz,
                                   voxel::InputExtent* reach = nullptr);
    /// Whether a cell, by itself, can be water at all: for most of the land no level need be
    /// requested.
    [[nodiscard]] bool may_be_water(const WaterCell& cell) const noexcept;
    /// Current size of the cache in bytes.
    [[nodiscard]] std::size_t memory_bytes() const;

private:
    class Impl;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace terravox::water
