#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "voxelserver/export/vox/colour_counts.hpp"

namespace terravox::exports {

/// A few colours that stand for many.
struct FewColours {
    std::vector<voxel::Rgb8> colours;
    std::vector<std::uint8_t> of_cell;  ///< for each cell given, which of `colours` stands for it
};

/// The `most` colours that differ least from those of the cells, as the eye sees it (squared
/// distance in OKLab, summed over all counted colours): exactly theirs where they are as few.
/// Depends on nothing but what is given: the same on every machine. Ref: Heckbert, "Color Image
/// Quantization for Frame Buffer Display", SIGGRAPH 1982 (median cut), here cut where the spread is
/// largest; Lloyd, "Least Squares Quantization in PCM", 1982 (k-means); Ottosson, "A perceptual
/// color space for image processing", 2020 (OKLab).
/// @param most 1 to 255; at least one cell
[[nodiscard]] FewColours few_colours(std::span<const ColourCounts::Cell> cells, std::size_t most);

}  // namespace terravox::exports
