#pragma once

#include <filesystem>

#include "raytracer/core/output/film.hpp"
#include "raytracer/core/output/picture_info.hpp"

namespace terravox::output {

/// Writes a picture as a TIFF file, completely or not at all. Samples depend on
/// PictureInfo::tiff_samples: 8-bit sRGB with exposure and tone curve, or linear 32-bit float.
///
/// With PictureInfo::geo, a picture that looks straight down, it is a GeoTIFF for use as a layer in
/// a GIS: tiles of 512 pixels, deflate, overviews ("cloud optimized", where GDAL has its COG
/// driver), the CRS, and an alpha band that is 0 where the view misses the world. Without, it has
/// strips, deflate, and alpha where samples are floats.
///
/// All metadata are stored, with underscores for colons (terravox_holes).
/// @throws Error
void write_tiff(const Film& film, const std::filesystem::path& file, const PictureInfo& info);

}  // namespace terravox::output
