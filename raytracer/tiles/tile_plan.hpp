#pragma once

#include <string>
#include <vector>

#include "raytracer/tiles/tile.hpp"

namespace terravox {

/// The passes of a picture, coarse to fine: each doubles the resolution, keeps the quarter of the pixels that is there and traces the
/// other three (paper, Figure 3). The last pass has step 1, so that every pixel is traced exactly once.
/// @param coarse_step step of the first pass, a power of two @throws UsageError when it is not
[[nodiscard]] std::vector<std::vector<RenderTile>> plan_tiles(int width_px, int height_px, int coarse_step, int tile_px, const std::string& order);

}  // namespace terravox
