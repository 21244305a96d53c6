#pragma once

#include <filesystem>

#include "raytracer/analyse/raster/cell_file.hpp"
#include "raytracer/core/output/picture_info.hpp"

namespace terravox::analyse {

/// @throws UsageError unless the file's name is that of a TIFF; Error when it cannot be written
void check_raster_target(const std::filesystem::path& out);

/// Writes a raster as a Cloud Optimized GeoTIFF: tiles, overviews (of single cells, since means of
/// classes mean nothing), nodata, and for each band its name and unit. Completely or not at all.
/// @param info georeference and metadata
/// @param threads for compression
/// @throws Error
void write_raster(CellFile& cells, const std::filesystem::path& out,
                  const output::PictureInfo& info, int threads);
/// The same of a dataset. @param attempt for messages
void write_raster(GDALDatasetH cells, const std::string& attempt, const std::filesystem::path& out,
                  const output::PictureInfo& info, int threads, bool has_floats);

}  // namespace terravox::analyse
