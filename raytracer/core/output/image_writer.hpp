#pragma once

#include <filesystem>

#include "raytracer/core/output/picture.hpp"

namespace terravox::output {

/// What a picture may be called, for help.
inline constexpr const char* kPictureEndings =
    ".png .jpg (8-bit), .exr .tif (float), and where OpenImageIO writes them .dpx .jxl .tga .webp "
    "(8-bit), .hdr (float)";

/// Whether a file is to be written as OpenEXR: the format that keeps layers and full precision.
[[nodiscard]] bool is_exr(const std::filesystem::path& file);

/// @throws UsageError when the file's extension names no supported format, or one that does not
/// hold a picture of that size; Error when its folder is not writable
void check_image_target(const std::filesystem::path& file, int width_px, int height_px);

/// Writes the film, completely or not at all, in the format of the file's extension:
///   .exr        linear 32-bit float, and the film's layers, where it has any (exr_channels.hpp)
///   .tif        linear 32-bit float R, G, B, A, or 8-bit sRGB, by PictureInfo::tiff_samples, in
///               strips; all metadata, with underscores for colons (terravox_holes). With
///               PictureInfo::geo it is a GeoTIFF for use as a layer in a GIS: tiles of 512 pixels,
///               overviews ("cloud optimized", where GDAL has its COG driver), the CRS, and an
///               alpha band that is 0 where the view misses the world
///   .png        8-bit sRGB through exposure and tone curve (develop.hpp), with all metadata
///   .jpg        the same, of quality 95, with those metadata that have a place in Exif: software,
///               copyright and description, up to 16 KiB of each (a warning says when that is not
///               all)
/// and where the installed OpenImageIO writes them:
///   .hdr        linear, 8 bits of each primary and a common exponent
///   .dpx .jxl .tga .webp   as .jpg; webp and jxl of quality 95
/// @throws UsageError for another extension; Error when the file cannot be written
void write_image(const Film& film, const std::filesystem::path& file, const PictureInfo& info);

}  // namespace terravox::output
