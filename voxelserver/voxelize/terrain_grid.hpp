#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "voxelserver/voxelize/class_table.hpp"
#include "voxelserver/voxelize/square.hpp"

namespace terravox::voxelize {

/// A coarse picture of the whole data set, made once from all points: ground heights everywhere, water surfaces as connected
/// bodies, and the lowest ground. It answers what a column's neighbourhood cannot: how high the ground is in the middle of a wide
/// void, and how high a lake stands.
///
/// Build: add_square() for each square in order, then finish(). Afterwards immutable and thread-safe.
class TerrainGrid {
public:
    static constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

    /// @param min_x .. max_z voxels, relative to the base, half-open; @param density points for each square voxel
    TerrainGrid(std::int32_t min_x, std::int32_t min_z, std::int32_t max_x, std::int32_t max_z, double density, double voxel_m);

    void add_square(const Square& square, const ClassTable& classes);
    /// Marks cells inside a file's stated bounds (voxels relative to the base, half-open): only there can a void be water.
    void cover(std::int32_t min_x, std::int32_t min_z, std::int32_t max_x, std::int32_t max_z);
    void finish();

    [[nodiscard]] int cell_voxels() const noexcept { return m_cell; }
    /// Ground height in voxels, interpolated over voids; defined everywhere inside when the data set has any ground.
    [[nodiscard]] float ground(std::int32_t x, std::int32_t z) const noexcept;
    /// Water surface in voxels when the column's cell belongs to a water body, else kNone.
    [[nodiscard]] float water(std::int32_t x, std::int32_t z) const noexcept;
    /// The same, also looking at the eight cells around: for columns that have water points of their own.
    [[nodiscard]] float water_near(std::int32_t x, std::int32_t z) const noexcept;
    [[nodiscard]] float lowest() const noexcept { return m_lowest; }    ///< of ground and water, voxels
    [[nodiscard]] float highest() const noexcept { return m_highest; }  ///< of any kept point, voxels

private:
    struct Cell {
        float ground_sum = 0, water_sum = 0;
        std::uint32_t ground_count = 0, water_count = 0, other_count = 0;
        bool covered = false;
    };
    [[nodiscard]] std::int64_t index(std::int32_t cx, std::int32_t cz) const noexcept { return static_cast<std::int64_t>(cz) * m_width + cx; }
    [[nodiscard]] std::int32_t cell_x(std::int32_t x) const noexcept { return (x >> m_shift) - m_origin_x; }
    [[nodiscard]] std::int32_t cell_z(std::int32_t z) const noexcept { return (z >> m_shift) - m_origin_z; }
    [[nodiscard]] bool inside(std::int32_t cx, std::int32_t cz) const noexcept { return cx >= 0 && cz >= 0 && cx < m_width && cz < m_height; }
    void fill_ground();
    void find_water();

    int m_shift = 1, m_cell = 2;
    double m_voxel_m = 1;
    std::int32_t m_origin_x = 0, m_origin_z = 0, m_width = 0, m_height = 0;
    std::vector<Cell> m_cells;      // released by finish()
    std::vector<float> m_ground, m_water;
    float m_lowest = std::numeric_limits<float>::infinity(), m_highest = -std::numeric_limits<float>::infinity();
};

}  // namespace terravox::voxelize
