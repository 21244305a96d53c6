#pragma once

#include <span>
#include <string>

#include "voxelserver/serve/map/hill_shade.hpp"

namespace terravox::map {

/// Encodes a PNG file of a map (common/png/png.hpp).
/// @param pixels row by row from the top; width * height of them
/// @throws Error when their number is wrong, a side is not in [1, 8192], or libpng fails
[[nodiscard]] std::string png_of(std::span<const Rgba8> pixels, int width, int height);

}  // namespace terravox::map
