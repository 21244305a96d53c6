#pragma once

#include <vector>

#include "raytracer/core/base/scene_words.hpp"
#include "raytracer/core/tiles/tile.hpp"

namespace terravox::tiles {

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
