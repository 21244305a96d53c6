#pragma once

#include <filesystem>
#include <initializer_list>
#include <string_view>
#include <vector>

namespace terravox::util {

/// Replaces each folder in `paths` by the files in it that have one of the endings (lower case,
/// with dot; any case matches), sorted by name. Files are kept as they are, whatever their ending.
/// A file that is named twice is kept once, even when its names differ (`./a`, links): by the name
/// that sorts first, so that the order of `paths` does not choose it.
/// @param what names the kind of thing in messages, e.g. "LiDAR data"
/// @throws UsageError for a folder without such a file, or a path that does not exist
[[nodiscard]] std::vector<std::filesystem::path> expand_folders(
    const std::vector<std::filesystem::path>& paths,
    std::initializer_list<std::string_view> endings, std::string_view what);

}  // namespace terravox::util
