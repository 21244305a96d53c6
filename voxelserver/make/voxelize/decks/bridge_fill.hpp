#pragma once

#include "voxelserver/make/voxelize/columns/window.hpp"
#include "voxelserver/make/voxelize/decks/deck_finder.hpp"
#include "voxelserver/make/voxelize/steps/vegetation_fill.hpp"

namespace terravox::voxelize {

/// Step "bridges": the deck over each column, where there is one. A column belongs to a deck when a
/// large enough share of its low returns are of bridges; gaps between points take the median of the
/// decks around. The space beneath stays open when columns become runs.
/// @param found decks without a bridge class; nullptr = none
[[nodiscard]] Margined<Surface> fill_decks(const Window& window, const FoundDecks* found = nullptr);

/// Sets the water under found decks, at the level of the water next to them. Its bed is shallow,
/// since its surroundings were taken for land.
void flow_beneath(const FoundDecks& found, double depth_m, WaterColumns& water);

/// Lowers the ground under found decks, and in gaps next to them.
void lower_ground(const FoundDecks& found, GroundHeights& ground);

/// Removes crowns on found decks: a plant less than `trunk_from_m` above the deck is not a tree.
void clear_crowns(const FoundDecks& found, double trunk_from_m, double voxel_m,
                  Margined<Crown>& crowns);

/// The columns' own bridge points and nothing else, for when the step is switched off.
[[nodiscard]] Margined<Surface> seen_decks(const Window& window);

}  // namespace terravox::voxelize
