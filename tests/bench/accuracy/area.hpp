#pragma once

#include <cstddef>
#include <cstdint>

namespace terravox::bench {

/// A rectangle of columns of 1 m: whole metres of easting and northing, north row first, as the
/// survey's truth. Column (c, r) has its centre at easting west + c + 0.5, northing north - r -
/// 0.5; as a voxel of 1 m it is x = west + c, z = -north + r.
struct Area {
    std::int64_t west = 0;
    std::int64_t north = 0;
    int width = 0;
    int height = 0;
    [[nodiscard]] std::size_t size() const noexcept {
        return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    }
    [[nodiscard]] std::size_t index(int column, int row) const noexcept {
        return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(column);
    }
    [[nodiscard]] bool holds(int column, int row) const noexcept {
        return column >= 0 && row >= 0 && column < width && row < height;
    }
    [[nodiscard]] std::int32_t voxel_x(int column) const noexcept {
        return static_cast<std::int32_t>(west + column);
    }
    [[nodiscard]] std::int32_t voxel_z(int row) const noexcept {
        return static_cast<std::int32_t>(row - north);
    }
};

}  // namespace terravox::bench
