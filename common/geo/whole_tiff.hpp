#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace terravox::geo {

/// Looks whether a TIFF file that GDAL has written and closed is all there. GDAL (3.6, at least)
/// does not say when its last write fails, as it does on a full disk: the file then ends before
/// pixels that its directories speak of. Reads the directories alone, of the image and of its
/// overviews. Thread-safe; start_gdal() or the like must have been called.
/// @return what is missing, in a few words; nullopt: nothing
[[nodiscard]] std::optional<std::string> missing_of_tiff(const std::filesystem::path& file);

/// Looks whether all directories of a TIFF file, whoever made it, lie within it, with their lists
/// of where blocks lie. GDAL passes over those that do not: of a file that was cut short the
/// overviews are gone without a word. Reads the directories alone. Thread-safe.
/// @return which one is lost, in a few words; nullopt: none, or it is no TIFF file
[[nodiscard]] std::optional<std::string> lost_directory_of_tiff(const std::filesystem::path& file);

}  // namespace terravox::geo
