#pragma once

#include <cstdint>
#include <functional>

#include "voxelserver/make/voxelize/columns/window.hpp"

namespace terravox::voxelize {

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
