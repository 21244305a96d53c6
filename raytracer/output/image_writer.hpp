#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "raytracer/output/film.hpp"

namespace terravox {

/// Text stored in the picture: name and value.
using ImageMetadata = std::vector<std::pair<std::string, std::string>>;

/// @throws UsageError when the file's ending names no format that can be written; Error when its folder cannot be written to
void check_image_target(const std::filesystem::path& file);

/// Writes the film: .exr and .tif as linear 32-bit float (R, G, B, A, and Z = distance in metres in EXR), .png and .jpg as 8-bit sRGB
/// through exposure and tone curve. Whole or not at all. @throws Error
void write_image(const Film& film, const std::filesystem::path& file, double exposure_ev, const std::string& tone, const ImageMetadata& metadata);

/// One pixel through exposure and tone curve, sRGB in [0, 1].
[[nodiscard]] Colour develop(Colour linear, double exposure_ev, const std::string& tone) noexcept;

}  // namespace terravox
