#pragma once

#include <array>
#include <optional>
#include <vector>

#include "voxelserver/out/export/core/job.hpp"

namespace terravox::exports {

/// The part of a world that the user requests.
struct Selection {
    int level = 0;
    /// West, south, east, north in the world's CRS; x0, z0, x1, z1 in voxels of level 0 in a world
    /// without one; empty: all.
    std::vector<double> area;
    std::vector<double> heights;  ///< lowest, highest, metres; empty: all
};

/// The part of a world inside a selection; where no area is given for an unbounded world, what a
/// camera frames.
/// @throws UsageError for a level that the world does not have, reversed limits, an empty result,
/// and more than 4096 boxes above each other
[[nodiscard]] Part part_of(const voxel::WorldInfo& world, const Selection& selection);

}  // namespace terravox::exports
