#pragma once

#include <cstdint>

#include "common/voxel/material.hpp"

namespace terravox::store {

/// One return in voxel space, in fixed point: x and z are relative to the first column of its
/// patch, y is absolute. Because fractions are rounded down, `>> bits` gives exactly the voxel that
/// contained the original point. Stored as is in prepared squares.
struct VoxelPoint {
    static constexpr int kPlanBits = 10;    ///< fraction of x and z: 64 columns fill 16 bits
    static constexpr int kHeightBits = 12;  ///< fraction of y: heights up to 524,287 voxels
    std::uint16_t x = 0;
    std::uint16_t z = 0;
    std::int32_t y = 0;
    std::uint8_t source_class = 0;
    /// Of the point itself where its square has colours; elsewhere `r` is its brightness.
    voxel::Rgb8 colour;

    [[nodiscard]] int column() const noexcept { return (z >> kPlanBits) * 64 + (x >> kPlanBits); }
    [[nodiscard]] float height() const noexcept {
        return static_cast<float>(y) * (1.0f / (1 << kHeightBits));
    }
    /// How bright a single return is, in hundredths of bright ground, up to 255; 0 = not known.
    /// Valid where the square has no colours.
    [[nodiscard]] std::uint8_t brightness() const noexcept { return colour.r; }
    [[nodiscard]] std::int32_t voxel_y() const noexcept { return y >> kHeightBits; }
};
static_assert(sizeof(VoxelPoint) == 12);

}  // namespace terravox::store
