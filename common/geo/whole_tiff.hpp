#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace terravox::geo {

/// Looks whether a TIFF file that GDAL has written and closed is all there. GDAL (3.6, at least) does not say when its last
/// write fails, as it does on a full disk: the file then ends before pixels that its directories speak of.
/// Reads the directories alone, of the image and of its overviews. Thread-safe; start_gdal() or the like must have been called.
/// @return what is missing, in a few words; nullopt: nothing
[[nodiscard]] std::optional<std::string> missing_of_tiff(const std::filesystem::path& file);

}  // namespace terravox::geo
