#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/voxel/world.hpp"
#include "voxelserver/water/evidence.hpp"
#include "voxelserver/water/water_cells.hpp"

namespace terravox::water {

/// Farther than any world goes.
inline constexpr voxel::InputExtent kAnywhere{-(1 << 26), -(1 << 26), 1 << 26, 1 << 26};

struct WaterOptions {
    int cell_voxels = 2;   ///< edge of a cell; a divisor of 64
    double voxel_m = 1;    ///< above 0
    bool equalize = true;  ///< false: levels as they were seen (body_levels.hpp)
    Evidence evidence;     ///< what counts as water
    /// A body that touches more patches than this is cut along the lines of a fixed grid of squares
    /// of at most so many patches. Exploring holds the cells of that many patches: 16 bytes a cell,
    /// 256 MB for cells of 2 voxels. At least 16.
    std::size_t max_body_patches = 16384;
    /// Of remembered levels; beyond it everything is forgotten and found again when asked. One body
    /// may exceed it.
    std::size_t memory_bytes = std::size_t{512} << 20;
};

/// Finds water bodies when a cell of theirs is first asked for, and remembers their levels.
///
/// Results do not depend on what was asked first, nor on threads: a body is collected whole, its
/// cells are sorted, then levels are computed. Thread-safe. Dry cells (anything that is no
/// candidate, see evidence.hpp) cost one call of the source and load no other patch: ask only for
/// the cells that are needed, since exploring one body may read many patches. Bodies that fit in
/// nine patches, which is nearly every void, are explored without a lock; larger ones one after the
/// other, while other threads go on with what is dry, small or known. The source must not call
/// back. Memory: 4 bytes a cell in patches with water, 2 bytes a cell in patches with any candidate
/// that was explored, about 200 bytes each. Whatever the source throws passes through; nothing is
/// remembered of that exploration.
class WaterBodies {
public:
    /// @throws Error for an option out of range
    WaterBodies(CellSource& source, const WaterOptions& options);
    ~WaterBodies();
    WaterBodies(const WaterBodies&) = delete;
    WaterBodies& operator=(const WaterBodies&) = delete;

    /// @param cx, cz cell index: columns [cx, cx + 1) * cell_voxels, and so on
    /// @param reach grows by the patches that the answer was made from, whoever asked first: those
    /// of all candidates connected with the cell,
    ///        and those beside them. Whether a body is so large that it is cut depends on all of
    ///        it: then it becomes kAnywhere. May be null
    /// @return voxels; NaN where there is no water
    [[nodiscard]] float level(std::int32_t cx, std::int32_t cz,
                              voxel::InputExtent* reach = nullptr);
    /// The same; where there is none, that of one of the eight cells around (edges before corners,
    /// west, east, north, south).
    [[nodiscard]] float level_near(std::int32_t cx, std::int32_t cz,
                                   voxel::InputExtent* reach = nullptr);
    /// Whether a cell, alone, can be water at all: most of the land need not be asked for.
    [[nodiscard]] bool may_be_water(const WaterCell& cell) const noexcept;
    /// Bytes remembered now.
    [[nodiscard]] std::size_t memory_bytes() const;

private:
    class Impl;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace terravox::water
