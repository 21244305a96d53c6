#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "common/voxel/world.hpp"
#include "voxelserver/data/water/evidence.hpp"
#include "voxelserver/data/water/water_cells.hpp"

namespace terravox::water {

/// A patch's index.
struct PatchIndex {
    std::int32_t x = 0;
    std::int32_t z = 0;
    bool operator==(const PatchIndex&) const = default;
};
struct PatchIndexHash {
    std::size_t operator()(PatchIndex p) const noexcept {
        const std::uint64_t both = static_cast<std::uint64_t>(static_cast<std::uint32_t>(p.x))
                                       << 32 |
                                   static_cast<std::uint32_t>(p.z);
        return static_cast<std::size_t>((both ^ both >> 29) * 0x9e3779b97f4a7c15u >> 7);
    }
};
/// One byte per cell of a patch, not 0 = set.
using CellFlags = std::vector<std::uint8_t>;
using FlaggedPatches = std::unordered_map<PatchIndex, CellFlags, PatchIndexHash>;

/// Floor division; b > 0.
[[nodiscard]] constexpr std::int32_t floor_div(std::int32_t a, std::int32_t b) noexcept {
    return a / b - (a % b < 0 ? 1 : 0);
}

/// Loads the cells of one patch and checks them.
/// @throws Error when the source returns null or a patch of another size
[[nodiscard]] std::shared_ptr<const CellPatch> checked_cells(CellSource& source, PatchIndex patch,
                                                             int side);

/// Limits of an exploration.
struct Bounds {
    std::size_t patches = 0;  ///< maximum number of loaded patches, including the first
    /// When set, the exploration stays within the patches of one square of a fixed grid: the
    /// square's edge in patches.
    std::optional<std::int32_t> square;
    /// Cells known to belong to a body that exceeds `patches`: reaching one ends the exploration as
    /// if the limit were exceeded. May be null.
    const FlaggedPatches* oversize = nullptr;
};

/// Collects all candidates connected (over edges) with one candidate, patch by patch.
class Exploration final : public Candidates {
public:
    /// Keeps references to `source` and `evidence`, which must outlive it.
    Exploration(CellSource& source, int side, const Evidence& evidence)
        : m_source(source), m_side(side), m_evidence(evidence) {}

    /// @param start a candidate
    /// @return false when the body extends beyond the bounds: the set of reached cells then depends
    /// on the start
    [[nodiscard]] bool run(CellPlace start, const Bounds& bounds);
    /// Sorts the found cells; call it once, after run().
    void list();

    [[nodiscard]] const std::vector<CellPlace>& places() const override { return m_places; }
    [[nodiscard]] const WaterCell* find(CellPlace place) const override;
    /// Covers every patch that was examined; for a finished exploration it does not depend on the
    /// start.
    [[nodiscard]] voxel::InputExtent reach() const noexcept;
    /// Calls visit(patch, flags of the cells found in it) for each patch with such cells, in
    /// unspecified order.
    template <class Visit>
    void for_each_patch(const Visit& visit) const {
        for (const auto& [patch, v] : m_visits)
            if (v.count > 0)
                visit(patch, v.found);
    }

private:
    struct Visited {
        std::shared_ptr<const CellPatch> cells;
        CellFlags found;
        std::vector<std::int32_t> waiting;  // found, neighbours not examined yet
        std::uint32_t count = 0;
        const CellFlags* oversize = nullptr;
    };
    Visited* visit(PatchIndex patch);
    void touch(PatchIndex patch, Visited& v, int x, int z);
    void spread(PatchIndex patch);
    void cross(PatchIndex to, int x, int z);

    CellSource& m_source;
    int m_side;
    const Evidence& m_evidence;
    Bounds m_bounds;
    PatchIndex m_square;  // square of the start, when limited to one
    bool m_exceeded = false;
    std::unordered_map<PatchIndex, Visited, PatchIndexHash> m_visits;
    std::vector<PatchIndex> m_queue;
    std::vector<CellPlace> m_places;
};

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
