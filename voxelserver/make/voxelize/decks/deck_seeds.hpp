#pragma once

#include <optional>

#include "voxelserver/make/voxelize/decks/deck_section.hpp"
#include "voxelserver/make/voxelize/steps/ground_fill.hpp"

namespace terravox::voxelize {

/// Columns of a patch and a margin, 1 = to be searched by DeckSections.
using DeckSeeds = Grid<char, GroundHeights::kMargin + DeckReach::kGrown>;

/// Columns that may belong to a deck without a bridge class: those between two drops along a row or
/// along a line of columns, no farther apart than a deck is wide. Wherever the land has no such
/// drops this is the only cost of the search for decks, so it reads only the patches' rows of
/// numbers and bits. Every column that DeckSections accepts is among the seeds; voids count as low,
/// since their level is not queried.
/// @return nullopt when there is none
[[nodiscard]] std::optional<DeckSeeds> find_deck_seeds(const Window& window,
                                                       const DeckLimits& limits);

}  // namespace terravox::voxelize
