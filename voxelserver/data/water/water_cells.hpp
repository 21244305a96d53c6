#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

namespace terravox::water {

constexpr float kNoLevel = std::numeric_limits<float>::quiet_NaN();

/// One cell of the coarse grid in which water is detected (edge: several voxels, a divisor of 64).
/// Heights in absolute voxels.
struct WaterCell {
    float water = kNoLevel;          ///< mean height of the water returns, NaN where there is none
    float ground = kNoLevel;         ///< mean height of the ground returns, NaN where there is none
    std::uint16_t water_points = 0;  ///< all three counts saturate
    std::uint16_t ground_points = 0;
    /// Roofs, plants, objects; NOT bridges: nothing is known about the surface below a deck.
    std::uint16_t other_points = 0;
    bool covered = false;    ///< inside the survey
    bool looks_wet = false;  ///< the orthophoto shows water in most of the cell's columns
};

/// The cells of one patch, row by row (index z * side + x; x east, z south). Immutable after
/// publication.
struct CellPatch {
    int side = 0;                  ///< cells along an edge: 64 / (voxels per cell edge)
    std::vector<WaterCell> cells;  ///< side * side elements
    [[nodiscard]] const WaterCell& at(int x, int z) const noexcept {
        return cells[static_cast<std::size_t>(z * side + x)];
    }
};

/// A source of cells; making a patch may read points, so it may take long. Thread-safe; the same
/// patch always has the same cells.
class CellSource {
public:
    virtual ~CellSource() = default;
    /// @param px, pz patch index: columns [64 px, 64 px + 64) x [64 pz, 64 pz + 64)
    /// @return never null; outside the survey all cells are uncovered
    virtual std::shared_ptr<const CellPatch> cells(std::int32_t px, std::int32_t pz) = 0;
};

/// The position of a cell in the grid of cells: x east, z south.
struct CellPlace {
    std::int32_t x = 0;
    std::int32_t z = 0;
    bool operator==(const CellPlace&) const = default;
};

/// @param i the index of a cell or of a section, not Adjacency::kNone
[[nodiscard]] constexpr std::size_t to_index(std::int32_t i) noexcept {
    return static_cast<std::size_t>(i);
}

enum Side : int { kWest = 0, kEast = 1, kNorth = 2, kSouth = 3 };

/// The adjacency of the cells in a list. No grid is stored, so that memory for a long river grows
/// with its cells and not with its bounding box.
class Adjacency {
public:
    static constexpr std::int32_t kNone = -1;

    /// @param places sorted by z, then x; no duplicates
    explicit Adjacency(const std::vector<CellPlace>& places);

    [[nodiscard]] std::int32_t size() const noexcept {
        return static_cast<std::int32_t>(m_neighbours.size());
    }
    /// @return the index of the cell on that side, or kNone
    [[nodiscard]] std::int32_t neighbour(std::int32_t i, Side side) const noexcept {
        return m_neighbours[static_cast<std::size_t>(i)][side];
    }
    [[nodiscard]] const std::array<std::int32_t, 4>& around(std::int32_t i) const noexcept {
        return m_neighbours[static_cast<std::size_t>(i)];
    }
    /// @return the diagonal neighbour (west or east, north or south) when one of the two cells
    /// between is in the list too, else kNone
    [[nodiscard]] std::int32_t diagonal(std::int32_t i, Side x_side, Side z_side) const noexcept {
        if (const std::int32_t a = neighbour(i, x_side); a != kNone)
            if (const std::int32_t d = neighbour(a, z_side); d != kNone)
                return d;
        const std::int32_t b = neighbour(i, z_side);
        return b == kNone ? kNone : neighbour(b, x_side);
    }

    /// Labels the connected components (over edges) of the cells with flag[i] != 0.
    /// @return the component of each cell, numbered from 0 in the order of their first cells; kNone
    /// where the flag is 0
    [[nodiscard]] std::vector<std::int32_t> parts(const std::vector<char>& flag,
                                                  std::int32_t* count = nullptr) const;

private:
    std::vector<std::array<std::int32_t, 4>> m_neighbours;
};

}  // namespace terravox::water
