#pragma once

#include <filesystem>
#include <string>

#include "raytracer/core/output/develop.hpp"
#include "raytracer/core/output/picture.hpp"

namespace terravox::output {

/// The longest side of a JPEG picture that libjpeg writes, pixels.
constexpr int kMaxJpegSide_px = 65500;

/// Writes a picture as a JPEG file of quality 95, completely or not at all: 8-bit sRGB with
/// exposure and tone curve. Of the metadata, those with a place in Exif are stored: software,
/// copyright and description, up to 16 KiB of each (a warning says when that is not all).
/// @throws Error
void write_jpeg(const Film& film, const std::filesystem::path& file, const PictureInfo& info);

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

/// Whether a file is to be written as OpenEXR: the format that keeps layers and full precision.
[[nodiscard]] bool is_exr(const std::filesystem::path& file);

/// @throws UsageError when the file's extension names no supported format, or one that does not
/// hold a picture of that size; Error when its folder is not writable
void check_image_target(const std::filesystem::path& file, int width_px, int height_px);

/// Writes the film, completely or not at all, in the format of the file's extension:
///   .exr        linear 32-bit float, and the film's layers, where it has any (exr_file.hpp)
///   .tif        linear 32-bit float R, G, B, A; a GeoTIFF where `info` has a place for it
///               (picture.hpp), 8-bit unless `info` specifies otherwise
///   .png .jpg   8-bit sRGB through exposure and tone curve (develop.hpp)
/// @throws UsageError for another extension; Error when the file cannot be written
void write_image(const Film& film, const std::filesystem::path& file, const PictureInfo& info);

}  // namespace terravox::output
