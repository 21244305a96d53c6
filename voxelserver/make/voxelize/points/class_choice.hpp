#pragma once

#include <optional>
#include <vector>

#include "voxelserver/data/grid/square_names.hpp"
#include "voxelserver/make/voxelize/points/class_table.hpp"
#include "voxelserver/make/voxelize/points/options.hpp"
#include "voxelserver/make/voxelize/points/placer.hpp"

namespace terravox::voxelize {

/// The class table that the options name. With kAnyClassTable, the one that is meant for such
/// files: the table of the source whose names the files have; else the one whose ClassTable::meant
/// fits their system, their place, and the classes of points from all over some files; else
/// `asprs`. Logs why, but for `asprs`. Depends on the files alone, not on their order.
/// @param files by path, each with a CRS
/// @param squares of each file, as list_squares() finds them
/// @throws UsageError for a table that is not there; Error for a file that cannot be sampled
[[nodiscard]] ClassTable choose_class_table(
    const LidarWorldOptions& options, const std::vector<SquareSource>& files,
    const std::vector<std::optional<grid::NamedSquare>>& squares);

}  // namespace terravox::voxelize
