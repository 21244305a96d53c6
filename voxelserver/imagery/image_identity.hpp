#pragma once

#include <filesystem>

#include "common/voxel/world.hpp"

namespace terravox::imagery {

/// A number for all that GDAL reads of an image: its file (store/file_identity.hpp), the files beside it that may tell where it lies or hold
/// its overviews and masks (world file, .aux.xml, .ovr, .msk, .prj, .tab), and the files that a .vrt is made of.
/// The caller holds gdal_mutex(). @throws Error when the file cannot be read
[[nodiscard]] voxel::Fingerprint image_identity(const std::filesystem::path& file);

}  // namespace terravox::imagery
