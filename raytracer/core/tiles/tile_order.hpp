#pragma once

#include <cstdint>
#include <vector>

#include "raytracer/core/base/scene_words.hpp"

namespace terravox::tiles {

/// A position in the grid of tiles: column from the left, row from the top.
struct TileCell {
    std::int32_t column = 0;
    std::int32_t row = 0;
    friend bool operator==(const TileCell&, const TileCell&) = default;
};

/// All cells of a grid, each once, in the order in which they are traced. No picture depends on the
/// order.
///   kRows           row by row from the top, each from the left
///   kVertical       column by column from the left, each from the top
///   kVerticalSplit  column by column; in each, the upper and the lower half take turns, both from
///                   their top
///   kSpiral         from the middle outwards, ring by ring, each clockwise
///   kHilbert        along a Hilbert curve over the smallest square of a power of two that holds
///                   the grid
/// @param columns, rows each 1 to 2^20
[[nodiscard]] std::vector<TileCell> order_cells(int columns, int rows, core::TileOrder order);

}  // namespace terravox::tiles
