#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "common/voxel/box.hpp"
#include "common/voxel/material.hpp"

namespace terravox::map {

/// The visible top of one column, seen from straight above.
struct ColumnTop {
    std::int32_t y = 0;  ///< highest solid voxel, absolute, level 0; undefined with kAir
    voxel::Rgb8 colour;  ///< sRGB, before any shading
    voxel::Material material = voxel::Material::kAir;  ///< kAir: the column is empty
    [[nodiscard]] bool nothing() const noexcept { return material == voxel::Material::kAir; }
    friend bool operator==(const ColumnTop&, const ColumnTop&) = default;
};

/// A box column from above: 64 x 64 columns.
struct BoxTop {
    std::array<ColumnTop, static_cast<std::size_t>(voxel::kBoxSizeX) * voxel::kBoxSizeZ> columns;
    /// x, z in [0, 64)
    [[nodiscard]] const ColumnTop& at(int x, int z) const noexcept {
        return columns[static_cast<std::size_t>(z * voxel::kBoxSizeX + x)];
    }
};

/// Determines the map's colour of a voxel: its true colour is blended with that of its material, in
/// linear light. Water takes a smaller share, because reflections and waves in an image obscure
/// that it is water.
struct TopColours {
    voxel::Palette palette;
    /// Share of the true colour, for voxels that have one; [0, 100], as the ray tracer's
    /// quality.colour_mix.
    int true_percent = 85;
    int true_percent_water = 45;  ///< the same for water; [0, 100]
};

/// @param boxes level 0, of one box column, in any order; nullptr: air
/// @return nullptr when the column is empty
/// @throws Error for boxes of another level or of different box columns
[[nodiscard]] std::shared_ptr<const BoxTop> make_top(
    std::span<const std::shared_ptr<const voxel::Box>> boxes, const TopColours& colours);

}  // namespace terravox::map
