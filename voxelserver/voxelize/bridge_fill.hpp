#pragma once

#include "voxelserver/voxelize/window.hpp"

namespace terravox::voxelize {

/// Step "bridges": the deck over each column, where there is one. A column belongs to a deck when a good part of its low returns are of
/// bridges; gaps between points take the median of the decks around. What is beneath stays open when columns become runs.
[[nodiscard]] Margined<Surface> fill_decks(const Window& window);

/// The columns' own bridge points and nothing else: with the step switched off.
[[nodiscard]] Margined<Surface> seen_decks(const Window& window);

}  // namespace terravox::voxelize
