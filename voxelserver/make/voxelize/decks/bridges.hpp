#pragma once

#include <memory>

#include "voxelserver/make/voxelize/columns/columns.hpp"
#include "voxelserver/make/voxelize/decks/deck_section.hpp"
#include "voxelserver/make/voxelize/steps/ground_fill.hpp"
#include "voxelserver/make/voxelize/steps/vegetation_fill.hpp"

namespace terravox::voxelize {

/// What the search for decks found in a column. Heights in voxels.
struct FoundDeck {
    Surface deck;  ///< seen() = the column is a deck
    /// The land or water under it; without a deck: the level in a gap next to one. NaN = no better
    /// value is known.
    float below = kNoHeight;
    bool over_water = false;
    bool of_things = false;  ///< its returns are unclassified, but are not plants
};
using FoundDecks = Grid<FoundDeck, GroundHeights::kMargin>;

/// Finds decks without a bridge class: narrow, level strips of ground or of unclassified returns,
/// with an abrupt edge on both sides and one low level beyond both, water or land, that lead from
/// land to land.
///
/// A column belongs to a deck when the land can be cut across there (DeckSections), and the strip
/// ends neither in the water nor in low land within kAlong columns: followed to both ends, it
/// reaches land at its own height or continues. Over land, at least one end must be seen: walls are
/// longer. Unclassified returns are decks only over water. Buildings and decks that have a class
/// keep it. A result depends on nothing farther than 64 columns from its column, so neighbouring
/// patches agree.
/// @param water nullptr = levels of water only where it was seen
/// @return nullptr when there is none, which costs next to nothing
[[nodiscard]] std::unique_ptr<const FoundDecks> find_decks(const Window& window,
                                                           const ClassTable& classes,
                                                           WaterAccess* water,
                                                           const Settings::Bridges& settings,
                                                           double voxel_m);

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
