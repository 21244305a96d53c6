#pragma once

#include <filesystem>

#include "raytracer/core/output/film.hpp"
#include "raytracer/core/output/picture_info.hpp"

namespace terravox::output {

/// The longest side of a JPEG picture that libjpeg writes, pixels.
constexpr int kMaxJpegSide_px = 65500;

/// Writes a picture as a JPEG file of quality 95, completely or not at all: 8-bit sRGB with
/// exposure and tone curve. Of the metadata, those with a place in Exif are stored: software,
/// copyright and description, up to 16 KiB of each (a warning says when that is not all).
/// @throws Error
void write_jpeg(const Film& film, const std::filesystem::path& file, const PictureInfo& info);

}  // namespace terravox::output
