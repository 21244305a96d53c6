#pragma once

#include <array>
#include <optional>
#include <vector>

#include "voxelserver/export/core/job.hpp"

namespace terravox::exports {

/// What of a world a person asks for.
struct Selection {
    int level = 0;
    std::vector<double> area;  ///< west, south, east, north in the world's CRS; x0, z0, x1, z1 in
                               ///< voxels of level 0 in one without; empty: all
    std::vector<double> heights;  ///< lowest, highest, metres; empty: all
};

/// The part of a world that lies in a selection; of a world without end what a camera frames, where
/// no area is given.
/// @throws UsageError for a level that the world does not have, numbers upside down, where nothing
/// is left, and for more than 4096 boxes above each other
[[nodiscard]] Part part_of(const voxel::WorldInfo& world, const Selection& selection);

}  // namespace terravox::exports
