#pragma once

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

}  // namespace terravox::water
