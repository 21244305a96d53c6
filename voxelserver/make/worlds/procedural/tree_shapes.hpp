#pragma once

#include <array>
#include <cstdint>

#include "common/voxel/box.hpp"

namespace terravox::procedural {

enum class TreeKind : std::uint8_t { kOak, kBirch, kConifer, kPalm, kAcacia, kCactus, kBush };

/// One plant that stands on a column.
struct Tree {
    std::int32_t x = 0, z = 0;  ///< its column, level 0
    std::int32_t base = 0;      ///< y of its lowest voxel
    TreeKind kind = TreeKind::kOak;
    std::uint64_t hash = 0;  ///< of its place: determines size and details
    voxel::VoxelAttr trunk;
    voxel::VoxelAttr leaves;
};

/// A stretch of one column, half-open; y above the tree's base.
struct TreeRun {
    std::int32_t y0 = 0;
    std::int32_t y1 = 0;
    bool trunk = false;
};
struct TreeRuns {
    std::array<TreeRun, 12> runs;
    int count = 0;
};

inline constexpr int kTreeReach = 4;    ///< columns that a crown reaches from its trunk, at most
inline constexpr int kTreeHeight = 18;  ///< maximum height of a plant

/// Columns that this plant reaches from its trunk.
[[nodiscard]] int tree_reach(const Tree& tree) noexcept;
/// The parts of a plant in one column.
/// @param dx, dz from its trunk
[[nodiscard]] TreeRuns tree_runs(const Tree& tree, int dx, int dz) noexcept;

}  // namespace terravox::procedural
