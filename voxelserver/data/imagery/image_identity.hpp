#pragma once

#include <filesystem>

#include "common/voxel/world.hpp"

namespace terravox::imagery {

/// A fingerprint of everything that GDAL reads for an image: its file
/// (common/voxel/file_identity.hpp), the side files that may georeference it or hold its overviews
/// and masks (common/geo/side_files.hpp), and the source files of a .vrt (vrt_sources.hpp; those
/// named in its first 16 MiB). Does not use GDAL. Thread-safe.
/// @throws Error when the file cannot be read
[[nodiscard]] voxel::Fingerprint image_identity(const std::filesystem::path& file);

}  // namespace terravox::imagery
