#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace terravox::pointcloud {

/// Whether a file that a user named is a point file, by its first bytes or by its ending: damaged
/// files are included, so that opening them reports the error. Does not throw.
[[nodiscard]] bool is_point_file(const std::filesystem::path& file);

/// Like is_point_file(), for a file found in a folder that a user named, which may contain other
/// data: it must have one of the endings, and its content must not be recognised as something else
/// (a mesh). Does not throw.
[[nodiscard]] bool is_point_file_of_folder(const std::filesystem::path& file);

/// Replaces folders by the point files in them, sorted by name (common/util/files.hpp).
/// @throws UsageError for a folder without any, or a path that does not exist
[[nodiscard]] std::vector<std::filesystem::path> expand_point_files(
    const std::vector<std::filesystem::path>& paths);

/// The side file next to a point file that affects the result of opening it, such as a .prj file
/// with its CRS.
/// @return nullopt when there is none
[[nodiscard]] std::optional<std::filesystem::path> find_side_file(
    const std::filesystem::path& file);

/// The index in the list (list.hpp) of the format that should open a file: by its first bytes, else
/// by its ending.
/// @throws Error naming the file and all formats when it has none of them, or does not exist
[[nodiscard]] std::size_t find_format_by(const std::filesystem::path& file);

/// The names of all formats, for help and messages: "LAS, LAZ or COPC, PLY".
[[nodiscard]] std::string format_names();

}  // namespace terravox::pointcloud
