#pragma once

#include <filesystem>
#include <string>

#include "raytracer/core/output/develop.hpp"
#include "raytracer/core/output/film.hpp"
#include "raytracer/core/output/picture_info.hpp"

namespace terravox::output {

/// Whether a file is to be written as OpenEXR: the format that keeps layers and full precision.
[[nodiscard]] bool is_exr(const std::filesystem::path& file);

/// @throws UsageError when the file's extension names no supported format, or one that does not
/// hold a picture of that size; Error when its folder is not writable
void check_image_target(const std::filesystem::path& file, int width_px, int height_px);

/// Writes the film, completely or not at all, in the format of the file's extension:
///   .exr        linear 32-bit float, and the film's layers, where it has any (exr_channels.hpp)
///   .tif        linear 32-bit float R, G, B, A; a GeoTIFF where `info` has a place for it
///               (tiff_picture.hpp), 8-bit unless `info` specifies otherwise
///   .png .jpg   8-bit sRGB through exposure and tone curve (develop.hpp)
/// @throws UsageError for another extension; Error when the file cannot be written
void write_image(const Film& film, const std::filesystem::path& file, const PictureInfo& info);

}  // namespace terravox::output
