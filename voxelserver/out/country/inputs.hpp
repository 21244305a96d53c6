#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "voxelserver/out/country/plan.hpp"

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
/// @throws UsageError for any other input; Error when no file can be opened
[[nodiscard]] Inputs look_at_inputs(const worlds::WorldOptions& world);

/// What has changed since the plan was made, a line each: files that are gone, changed, or new. No
/// file is opened as a point cloud: it takes some 50 microseconds for each.
[[nodiscard]] std::vector<std::string> changes_since(const Plan& plan);

/// A file that is not as the plan has it.
struct FileChange {
    enum class Kind { kNew, kChanged, kGone, kUnreadable };
    Kind kind = Kind::kChanged;
    std::filesystem::path file;
    std::string error;  ///< of one that cannot be read; of others empty
};
[[nodiscard]] std::string to_text(const FileChange& change);

/// As changes_since(), of squares and of images apart.
struct InputChanges {
    std::vector<FileChange> squares;
    std::vector<FileChange> images;
};
/// @param world the plan's, or one that leaves out other files
/// @throws UsageError, Error when the inputs cannot be listed
[[nodiscard]] InputChanges compare_inputs(const Plan& plan, const worlds::WorldOptions& world);

/// Looks at one file, as look_at_inputs() does.
/// @return why it cannot be opened; empty: `file` is filled in
[[nodiscard]] std::string look_at(PlannedFile& file);

/// @throws Error unless this program makes the same boxes as the one that made the plan
void check_program(const Plan& plan, const std::string& attempt);

/// @throws Error unless this program makes the same boxes as the one that made the plan, of data
/// that are still the same
void check_current(const Plan& plan, const std::string& attempt);

}  // namespace terravox::country
