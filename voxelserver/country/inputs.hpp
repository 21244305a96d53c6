#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "voxelserver/country/plan.hpp"

namespace terravox::country {

/// What the inputs of a country are on the disk.
struct Inputs {
    std::vector<PlannedFile> squares;  ///< that can be opened, by path
    std::vector<PlannedFile> images;
    std::vector<MissingSquare> missing;           ///< by name
    std::vector<std::filesystem::path> left_out;  ///< files of missing squares, by path
};

/// Opens each point file that the options name, or that a store has, and reads a few points of it.
/// @param world whose inputs are LiDAR data or a store
/// @throws UsageError for any other input, or when no file can be opened
[[nodiscard]] Inputs look_at_inputs(const worlds::WorldOptions& world);

/// What has changed since the plan was made, a line each: files that are gone, changed, or new. No
/// file is opened as a point cloud: it takes some 50 microseconds for each.
[[nodiscard]] std::vector<std::string> changes_since(const Plan& plan);

/// @throws Error unless this program makes the same boxes as the one that made the plan, of data
/// that are still the same
void check_current(const Plan& plan, const std::string& attempt);

}  // namespace terravox::country
