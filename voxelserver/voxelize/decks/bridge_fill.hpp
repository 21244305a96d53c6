#pragma once

#include "voxelserver/voxelize/columns/window.hpp"
#include "voxelserver/voxelize/decks/deck_finder.hpp"
#include "voxelserver/voxelize/steps/vegetation_fill.hpp"

namespace terravox::voxelize {

/// Step "bridges": the deck over each column, where there is one. A column belongs to a deck when a
/// good part of its low returns are of bridges; gaps between points take the median of the decks
/// around. What is beneath stays open when columns become runs.
/// @param found decks that no class names; nullptr = none
[[nodiscard]] Margined<Surface> fill_decks(const Window& window, const FoundDecks* found = nullptr);

/// Water under found decks: as high as beside them. Its bed is shallow, since what lies around was
/// taken for land.
void flow_beneath(const FoundDecks& found, double depth_m, WaterColumns& water);

/// Land under found decks, and in gaps beside them.
void lower_ground(const FoundDecks& found, GroundHeights& ground);

/// What stands on a found deck grows there: nothing lower than `trunk_from_m` above it is a tree.
void clear_crowns(const FoundDecks& found, double trunk_from_m, double voxel_m,
                  Margined<Crown>& crowns);

/// The columns' own bridge points and nothing else: with the step switched off.
[[nodiscard]] Margined<Surface> seen_decks(const Window& window);

}  // namespace terravox::voxelize
