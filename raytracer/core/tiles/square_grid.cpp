#include "raytracer/core/tiles/square_grid.hpp"

#include <algorithm>
#include <cmath>

namespace terravox::tiles {
namespace {

// Limits the numbers for a world with invalid bounds.
constexpr std::int64_t kMaxAcross = 1 << 15;

std::int64_t to_floor(double v) noexcept {
    return static_cast<std::int64_t>(std::floor(v));
}

}  // namespace

SquareGrid::SquareGrid(const voxel::WorldInfo& world)
    : m_voxels_per_square(world.crs.empty() ? 1000 : 1000 / world.crs_units_per_voxel) {
    m_first_column = to_floor(world.bounds.min[0] / m_voxels_per_square);
    m_first_row = to_floor(world.bounds.min[2] / m_voxels_per_square);
    const auto count = [&](std::int64_t first, double end) {
        return static_cast<std::uint32_t>(std::clamp<std::int64_t>(
            to_floor((end - 1) / m_voxels_per_square) - first + 1, 1, kMaxAcross));
    };
    m_columns = count(m_first_column, world.bounds.max[0]);
    m_rows = count(m_first_row, world.bounds.max[2]);
}

std::uint32_t SquareGrid::compute_index(double x, double z) const noexcept {
    const auto place = [&](double v, std::int64_t first, std::uint32_t count) {
        return static_cast<std::uint32_t>(
            std::clamp<std::int64_t>(to_floor(v / m_voxels_per_square) - first, 0, count - 1));
    };
    return place(z, m_first_row, m_rows) * m_columns + place(x, m_first_column, m_columns);
}

std::string SquareGrid::to_name(std::uint32_t index) const {
    // z grows to the south: the row's southern edge has the smaller northing.
    return std::to_string(m_first_column + index % m_columns) + "_" +
           std::to_string(-(m_first_row + index / m_columns) - 1);
}

}  // namespace terravox::tiles
