#pragma once

#include <cstdint>
#include <functional>

#include "voxelserver/make/voxelize/columns/columns.hpp"

namespace terravox::voxelize {

/// 1 = the column belongs to the survey.
using Coverage = Grid<char, 8>;

/// The greatest radius of find_coverage(): it is used twice, within a window.
inline constexpr int kWidestRadius = (Window::kMargin - Coverage::kMargin) / 2;

/// The greatest radius of straighten_rim().
inline constexpr int kWidestRim = Coverage::kMargin - Margined<char>::kMargin;

/// Which columns belong to the survey: those inside the stated bounds of a file and not in the
/// middle of a wide void. Voids up to twice the radius are gaps between points (morphological
/// closing with a square); wider ones are holes, unless they are water.
///
/// Where the bounds end, a void closes when returns lie on both sides of it along the edge, as
/// anywhere else; the land extends a rim beyond the outermost return (an edge of a water cell, at
/// least a third of the radius), since the last points stop short of the bounds.
/// @param in_bounds inside some file's bounds; points outside are ignored
/// @param radius voxels, 1 to kWidestRadius
/// Ref: Serra, "Image Analysis and Mathematical Morphology", 1982 (closing).
[[nodiscard]] Coverage find_coverage(const Window& window,
                                     const Grid<char, Window::kMargin>& in_bounds, int radius);

/// The coverage without a fringe: where the lines of a scanner end one by one, the survey is cut
/// where half of the columns around, as far as they lie within the bounds, belong to it. Along
/// straight bounds nothing changes, and lone points stay.
/// @param radius of what is around, voxels, 0 to kWidestRim
/// Ref: a median filter of a binary image: Serra, as above.
[[nodiscard]] Margined<char> straighten_rim(const Coverage& covered,
                                            const Grid<char, Window::kMargin>& in_bounds,
                                            int radius);

/// Heights of the ground, in voxels, with the margin that crowns and their trunks need. NaN where
/// there is none.
using GroundHeights = Grid<float, 8>;

/// The height of the ground where none was seen within reach, absolute voxels: called rarely, may
/// be slow.
using AskWideGround = std::function<float(std::int32_t x, std::int32_t z)>;

/// Steps "k-d tree (ground)" and "ground fill": the height of the ground in every column that needs
/// one.
///
/// A column with ground points keeps their median. A small gap takes the mean of the columns around
/// it, weighted by distance, when they lie on at least three sides. In a wider gap (under a house)
/// a column takes the mean of the nearest ground in eight directions, when there is some on
/// opposite sides; else that of the nearest columns along the gap's edge. Nothing farther than 32
/// voxels counts; where there is none, `wide` is called.
/// @param wanted 1 = the column needs a ground (not water, not outside the survey)
[[nodiscard]] GroundHeights fill_ground(const Window& window,
                                        const Grid<char, GroundHeights::kMargin>& wanted,
                                        const AskWideGround& wide);

/// The columns' own medians and nothing else, for when the step is switched off.
[[nodiscard]] GroundHeights seen_ground(const Window& window);

}  // namespace terravox::voxelize
