#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace terravox::pointcloud {

/// Whether a file that a person names is one of points, by its first bytes or by its ending: a
/// damaged file counts, too, so that opening it says what is wrong. Throws nothing.
[[nodiscard]] bool is_point_file(const std::filesystem::path& file);

/// The same for a file of a folder that a person names, which may hold other data: one of these
/// endings, without content that is no point cloud (a mesh). Throws nothing.
[[nodiscard]] bool is_point_file_of_folder(const std::filesystem::path& file);

/// Replaces folders by the point files in them, sorted by name (common/util/files.hpp).
/// @throws UsageError for a folder without any, or a path that does not exist
[[nodiscard]] std::vector<std::filesystem::path> expand_point_files(
    const std::vector<std::filesystem::path>& paths);

/// The file beside a point file that shapes what opening it gives, such as a .prj file with its
/// CRS.
/// @return nullopt when there is none
[[nodiscard]] std::optional<std::filesystem::path> side_file_of(const std::filesystem::path& file);

/// The number of the format in the list (list.hpp) that should open a file: by its first bytes,
/// else by its ending.
/// @throws Error naming the file and all formats when it is of none, or is not there
[[nodiscard]] std::size_t format_of(const std::filesystem::path& file);

/// All formats for help and messages: "LAS, LAZ or COPC, PLY".
[[nodiscard]] std::string format_names();

}  // namespace terravox::pointcloud
