#pragma once

#include <filesystem>
#include <string>

#include "raytracer/output/develop.hpp"
#include "raytracer/output/film.hpp"
#include "raytracer/output/picture_info.hpp"

namespace terravox::output {

/// @throws UsageError when the file's ending names no format that can be written; Error when its
/// folder cannot be written to
void check_image_target(const std::filesystem::path& file);

/// Writes the film, whole or not at all, by the file's ending:
///   .exr           linear 32-bit float, and the film's layers, where it has any (exr_channels.hpp)
///   .tif           linear 32-bit float R, G, B, A; a GeoTIFF where `info` has a place for it
///   (geotiff.hpp), 8-bit if not told otherwise .png .jpg      8-bit sRGB through exposure and tone
///   curve (develop.hpp)
/// @throws Error
void write_image(const Film& film, const std::filesystem::path& file, const PictureInfo& info);

}  // namespace terravox::output
