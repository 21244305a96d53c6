#pragma once

#include <set>
#include <span>
#include <string>
#include <vector>

#include "voxelserver/voxelize/world/lidar_world.hpp"

namespace terravox::voxelize {

/// Columns of boxes of level 0 that depend on some squares.
struct DependentColumns {
    std::set<grid::PatchKey> dependent;
    /// Columns around them, up to kNeighbours, that do not; where there are none, in other islands.
    std::vector<grid::PatchKey> neighbours;
    static constexpr std::size_t kNeighbours = 8;
};

/// The columns of boxes whose voxels may be others once the points of some squares are: those that
/// read a patch of them. Most lie within a patch of a square; where a body of water, or a gap
/// without ground, reaches out of a square, others lie as far as that does.
///
/// A column that reads nothing of the squares is made of the same inputs before and after, so the
/// answer is the same for the world as it was, as long as the squares covered the same columns.
/// @param changed by number, as in LidarWorld::squares(); where materials are guessed from
/// intensities, those within 500 m of them count, too, since they share a scale
/// (points/brightness.hpp)
/// @param before where squares lay that have changed or are gone, in columns of the world
/// @param threads 0: one for each core
/// @throws Error for a damaged square
[[nodiscard]] DependentColumns columns_that_depend_on(
    LidarWorld& world, const std::set<std::size_t>& changed, int threads,
    std::span<const grid::ColumnRect> before = {});

/// The numbers of squares by their names.
/// @throws UsageError for a name that no square has, or that two have
[[nodiscard]] std::set<std::size_t> squares_named(const LidarWorld& world,
                                                  std::span<const std::string> names);

}  // namespace terravox::voxelize
