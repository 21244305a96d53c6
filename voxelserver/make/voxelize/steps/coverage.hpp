#pragma once

#include "voxelserver/make/voxelize/columns/window.hpp"

namespace terravox::voxelize {

/// Which columns belong to the survey: those inside the stated bounds of a file and not in the
/// middle of a wide void. Voids up to twice the radius are gaps between points (morphological
/// closing with a square); wider ones are holes, unless they are water.
///
/// Where the bounds end, a void closes when returns lie on both sides of it along the edge, as
/// anywhere else; the land extends a rim beyond the outermost return (an edge of a water cell, at
/// least 2 voxels), since the last points stop short of the bounds.
/// @param in_bounds inside some file's bounds; points outside are ignored
/// @param radius voxels, 1 to 31
/// Ref: Serra, "Image Analysis and Mathematical Morphology", 1982 (closing).
[[nodiscard]] Margined<char> find_coverage(const Window& window,
                                           const Grid<char, Window::kMargin>& in_bounds,
                                           int radius);

}  // namespace terravox::voxelize
