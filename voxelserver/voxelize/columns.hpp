#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "common/voxel/material.hpp"
#include "voxelserver/voxelize/class_table.hpp"
#include "voxelserver/voxelize/square.hpp"

namespace terravox::voxelize {

inline constexpr float kNoHeight = std::numeric_limits<float>::quiet_NaN();

/// A height with what was seen there. `height` in voxels (continuous); NaN = nothing seen.
struct Surface {
    float height = kNoHeight;
    std::uint8_t source_class = 0;
    bool has_colour = false;
    voxel::Rgb8 colour;
    [[nodiscard]] bool seen() const noexcept { return height == height; }
};

/// A voxel that holds points of a thing above the ground.
struct ObjectVoxel {
    std::int32_t y = 0;
    std::uint8_t source_class = 0;
    bool has_colour = false;
    voxel::Rgb8 colour;
};

/// What the points of one column say, before any neighbour is asked.
struct Column {
    Surface ground;  ///< median of the ground points
    Surface roof;    ///< highest building point
    Surface water;   ///< mean of the water points
    Surface deck;    ///< median of the bridge points
    std::uint32_t objects_begin = 0, objects_end = 0;  ///< into PatchColumns::objects, by rising y
};

/// The 64 x 64 columns of a patch, index = z * 64 + x (local). Immutable.
struct PatchColumns {
    std::array<Column, kPatchSize * kPatchSize> columns;
    std::vector<ObjectVoxel> objects;
    bool any = false;
    [[nodiscard]] std::size_t memory_bytes() const noexcept { return sizeof *this + objects.capacity() * sizeof(ObjectVoxel); }
};

/// The points of one square that fall into a patch.
struct PatchPoints {
    std::span<const VoxelPoint> points;
    int colour_shift = 0;
    bool has_colour = false;
};

/// Step "column init": sorts the points of a patch into columns and sums each up. The result does not depend on the order of
/// `sources` beyond ties of equal points.
[[nodiscard]] std::shared_ptr<const PatchColumns> init_columns(std::span<const PatchPoints> sources, const ClassTable& classes);

}  // namespace terravox::voxelize
