#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace terravox::geo {

/// Checks whether a TIFF file that GDAL has written and closed is complete. GDAL (3.6, at least)
/// does not report when its last write fails, as it does on a full disk: the file then ends before
/// pixels that its directories refer to. Reads only the directories, of the image and of its
/// overviews. Thread-safe; start_gdal() or an equivalent must have been called.
/// @return what is missing, in a few words; nullopt when the file is complete
[[nodiscard]] std::optional<std::string> find_missing_part_of_tiff(
    const std::filesystem::path& file);

/// Checks whether all directories of a TIFF file from any source lie within it, with their lists of
/// block offsets. GDAL silently skips those that do not: a truncated file loses its overviews
/// without an error. Reads only the directories. Thread-safe.
/// @return which directory is lost, in a few words; nullopt when none is, or the file is not a TIFF
[[nodiscard]] std::optional<std::string> find_lost_directory_of_tiff(
    const std::filesystem::path& file);

}  // namespace terravox::geo
