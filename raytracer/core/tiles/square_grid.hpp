#pragma once

#include <cstdint>
#include <string>

#include "common/voxel/world.hpp"

namespace terravox::tiles {

/// The kilometre squares (1000 units of the CRS) that contain a world's columns, numbered row by
/// row from the north-west. In worlds that are not georeferenced, squares of 1000 voxels.
class SquareGrid {
public:
    explicit SquareGrid(const voxel::WorldInfo& world);

    /// @param x, z level-0 voxels; points beyond the world belong to its outermost squares
    [[nodiscard]] std::uint32_t compute_index(double x, double z) const noexcept;
    [[nodiscard]] std::uint32_t count() const noexcept { return m_columns * m_rows; }
    /// Kilometres east and north of the south-west corner, as in "462_101".
    [[nodiscard]] std::string to_name(std::uint32_t index) const;

private:
    double m_voxels_per_square;
    std::int64_t m_first_column;
    std::int64_t m_first_row;
    std::uint32_t m_columns;
    std::uint32_t m_rows;
};

}  // namespace terravox::tiles
