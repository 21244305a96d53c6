#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "common/voxel/world.hpp"

namespace terravox::imagery {

/// Expands the given paths to image files, replacing folders by the images in them.
/// @throws UsageError for a path that does not exist
[[nodiscard]] std::vector<std::filesystem::path> orthophoto_files(
    const std::vector<std::filesystem::path>& paths);

/// Lists the source files of a virtual image (.vrt): <SourceFilename> and <SourceDataset>, each
/// once, in the order of the text, which is scanned without GDAL and without validating the rest.
/// Names marked as relative to the .vrt are resolved against its folder. The files need not exist.
/// @param text content of the .vrt, or of any other file with that ending
/// @param folder folder of the .vrt
/// @param most maximum number of files to return
[[nodiscard]] std::vector<std::filesystem::path> vrt_sources(std::string_view text,
                                                             const std::filesystem::path& folder,
                                                             std::size_t most);

/// A fingerprint of everything that GDAL reads for an image: its file
/// (common/voxel/fingerprint.hpp), the side files that may georeference it or hold its overviews
/// and masks (common/geo/raster_gate.hpp), and the source files of a .vrt (those
/// named in its first 16 MiB). Does not use GDAL. Thread-safe.
/// @throws Error when the file cannot be read
[[nodiscard]] voxel::Fingerprint image_identity(const std::filesystem::path& file);

}  // namespace terravox::imagery
