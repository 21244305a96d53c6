#pragma once

#include <filesystem>

#include "common/voxel/world.hpp"

namespace terravox::imagery {

/// A number for all that GDAL reads of an image: its file (store/file_identity.hpp), the files
/// beside it that may tell where it lies or hold its overviews and masks
/// (common/geo/side_files.hpp), and the files that a .vrt is made of (vrt_sources.hpp; of those
/// that it names in its first 16 MiB). Does without GDAL. Thread-safe. @throws Error when the file
/// cannot be read
[[nodiscard]] voxel::Fingerprint image_identity(const std::filesystem::path& file);

}  // namespace terravox::imagery
