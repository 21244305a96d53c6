#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "voxelserver/serve/map/column_top.hpp"

namespace terravox::map {

struct Rgba8 {
    std::uint8_t r = 0, g = 0, b = 0, a = 0;  ///< sRGB; straight alpha (not premultiplied)
    friend bool operator==(const Rgba8&, const Rgba8&) = default;
};

/// A column and its neighbours, row by row from the north-west: index 3 dz + dx + 4.
using TopWindow = std::array<const ColumnTop*, 9>;

/// Brightness of the middle column by its slope, light from the north-west at 45 degrees;
/// kFlatShade = the brightness of level ground.
///
/// Empty neighbours are treated as level with the middle. Differences of height are clamped to a
/// few voxels, so that walls and trees are outlined and not blackened. In [0.6, 1.25] kFlatShade.
/// Ref: Horn, "Hill shading and the reflectance map", Proceedings of the IEEE 69, 1981.
inline constexpr std::uint32_t kFlatShade = 4096;
[[nodiscard]] std::uint32_t hill_shade(const TopWindow& window) noexcept;

/// The map's pixel of the middle column: transparent where the column is empty; water is not
/// shaded.
[[nodiscard]] Rgba8 shaded_pixel(const TopWindow& window) noexcept;

/// Encodes a PNG file of a map (common/png/png.hpp).
/// @param pixels row by row from the top; width * height of them
/// @throws Error when their number is wrong, a side is not in [1, 8192], or libpng fails
[[nodiscard]] std::string to_png(std::span<const Rgba8> pixels, int width, int height);

}  // namespace terravox::map
