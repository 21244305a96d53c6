#pragma once

#include <set>
#include <span>
#include <string>
#include <vector>

#include "voxelserver/make/voxelize/world/lidar_world.hpp"

namespace terravox::voxelize {

/// Columns of boxes of level 0 that depend on some squares.
struct DependentColumns {
    std::set<grid::PatchKey> dependent;
    /// Columns around them, up to kNeighbours, that do not; where there are none, in other islands.
    std::vector<grid::PatchKey> neighbours;
    static constexpr std::size_t kNeighbours = 8;
};

/// What is known of the world before some squares changed.
struct WorldBefore {
    /// Where squares lay that have changed or are gone, in columns of the world.
    std::vector<grid::ColumnRect> lay;
    /// Whether the world knows the scales of intensities of before: as
    /// LidarWorld::rescaled_files().
    bool scales_are_known = false;
};

/// The columns of boxes whose voxels may be others once the points of some squares are: those that
/// read a patch of them. Most lie within a patch of a square; where a body of water, or a gap
/// without ground, reaches out of a square, others lie as far as that does.
///
/// A column that reads nothing of the squares is made of the same inputs before and after, so the
/// answer is the same for the world as it was, as long as the squares covered the same columns.
/// @param changed by number, as in LidarWorld::squares()
/// @param threads 0: one for each core
/// @throws Error for a damaged square
[[nodiscard]] DependentColumns columns_that_depend_on(LidarWorld& world,
                                                      const std::set<std::size_t>& changed,
                                                      int threads, const WorldBefore& before = {});

/// The numbers of squares by their names.
/// @throws UsageError for a name that no square has, or that two have
[[nodiscard]] std::set<std::size_t> squares_named(const LidarWorld& world,
                                                  std::span<const std::string> names);

}  // namespace terravox::voxelize
