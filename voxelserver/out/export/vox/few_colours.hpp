#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "voxelserver/out/export/vox/colour_counts.hpp"

namespace terravox::exports {

/// A few colours that represent many.
struct FewColours {
    std::vector<voxel::Rgb8> colours;
    std::vector<std::uint8_t> of_cell;  ///< for each given cell, the index of its colour
};

/// The `max_colours` colours that differ least from those of the cells, perceptually (squared
/// distance in OKLab, summed over all counted colours): exactly theirs where there are no more than
/// that. Depends only on the arguments: the same on every machine.
///
/// Ref: Heckbert, "Color Image Quantization for Frame Buffer Display", SIGGRAPH 1982 (median cut),
/// here cut where the spread is largest; Lloyd, "Least Squares Quantization in PCM", 1982
/// (k-means); Ottosson, "A perceptual color space for image processing", 2020 (OKLab).
/// @param cells at least one
/// @param max_colours 1 to 255
[[nodiscard]] FewColours few_colours(std::span<const ColourCounts::Cell> cells,
                                     std::size_t max_colours);

}  // namespace terravox::exports
