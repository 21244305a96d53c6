#pragma once

#include <memory>

#include "voxelserver/voxelize/decks/deck_section.hpp"
#include "voxelserver/voxelize/steps/ground_fill.hpp"

namespace terravox::voxelize {

/// What the search for decks found out about a column. Heights in voxels.
struct FoundDeck {
    Surface deck;             ///< seen() = the column is a deck
    float below = kNoHeight;  ///< the land or water under it; without a deck: what lies in a gap
                              ///< beside one. NaN = nothing is known better
    bool over_water = false;
    bool of_things = false;  ///< its returns are unclassified: they are no plants
};
using FoundDecks = Grid<FoundDeck, GroundHeights::kMargin>;

/// Finds decks that no class names: narrow, level strips of ground or of unclassified returns, with
/// an abrupt edge on both sides and one low level beyond both, water or land, that lead from land
/// to land.
///
/// A column belongs to a deck when the land can be cut across there (DeckSections), and what it is
/// cut from neither ends in the water nor in low land within kAlong columns: followed to both ends,
/// it comes to land at its own height or goes on. Over land, at least one end must be seen: walls
/// are longer. Unclassified returns are decks only over water. What stands on a class's word stays:
/// buildings, decks. A result depends on nothing farther than 64 columns from its column, so
/// neighbouring patches agree.
/// @param water nullptr = levels of water only where it was seen @return nullptr when there is
/// none, which costs next to nothing
[[nodiscard]] std::unique_ptr<const FoundDecks> find_decks(const Window& window,
                                                           const ClassTable& classes,
                                                           WaterAccess* water,
                                                           const Settings::Bridges& settings,
                                                           double voxel_m);

}  // namespace terravox::voxelize
