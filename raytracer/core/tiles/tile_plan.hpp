#pragma once

#include <cstdint>
#include <vector>

#include "raytracer/core/base/scene_words.hpp"
#include "raytracer/core/tiles/tile.hpp"

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

/// The passes of a picture, coarse to fine: each doubles the resolution, keeps the quarter of the
/// pixels that exists already and traces the other three (paper, Figure 3). The last pass has step
/// 1, so that every pixel is traced exactly once.
/// @param width_px, height_px, tile_px at least 1
/// @param coarse_step step of the first pass, a power of two
/// @param order of the tiles in each pass
/// @throws UsageError for a step that is no power of two, and for more than 2^20 tiles
[[nodiscard]] std::vector<std::vector<RenderTile>> plan_tiles(int width_px, int height_px,
                                                              int coarse_step, int tile_px,
                                                              core::TileOrder order);

}  // namespace terravox::tiles
