#include "raytracer/core/tiles/tile_plan.hpp"

#include <algorithm>
#include <bit>

#include "common/util/error.hpp"
#include "raytracer/core/tiles/tile_order.hpp"

namespace terravox::tiles {
namespace {

/// Tiles of one pass; more would need more memory than the pictures they are for.
constexpr std::int64_t kMaxTiles = std::int64_t{1} << 20;

void check(int width_px, int height_px, int coarse_step, int tile_px, std::int64_t tiles) {
    if (coarse_step < 1 || !std::has_single_bit(static_cast<unsigned>(coarse_step)))
        throw util::UsageError("plan the passes: quality.coarse_step = " +
                               std::to_string(coarse_step) + "; allowed: 1, 2, 4, 8, 16, 32, 64");
    if (tiles > kMaxTiles)
        throw util::UsageError("plan the tiles: " + std::to_string(tiles) + " tiles of " +
                               std::to_string(tile_px) + " pixels in a picture of " +
                               std::to_string(width_px) + "x" + std::to_string(height_px) +
                               "; allowed: up to " + std::to_string(kMaxTiles) +
                               ", so make quality.tile larger");
}

}  // namespace

std::vector<std::vector<RenderTile>> plan_tiles(int width_px, int height_px, int coarse_step,
                                                int tile_px, core::TileOrder order) {
    const int columns = (width_px + tile_px - 1) / tile_px;
    const int rows = (height_px + tile_px - 1) / tile_px;
    check(width_px, height_px, coarse_step, tile_px, std::int64_t{columns} * rows);
    const std::vector<TileCell> cells = order_cells(columns, rows, order);
    std::vector<std::vector<RenderTile>> passes;
    for (int step = coarse_step; step >= 1; step /= 2) {
        std::vector<RenderTile> tiles;
        tiles.reserve(cells.size());
        for (const TileCell& c : cells) {
            RenderTile tile;
            tile.index = static_cast<std::uint32_t>(tiles.size());
            tile.pass = static_cast<std::uint32_t>(passes.size());
            tile.x0 = c.column * tile_px;
            tile.y0 = c.row * tile_px;
            tile.x1 = std::min(tile.x0 + tile_px, width_px);
            tile.y1 = std::min(tile.y0 + tile_px, height_px);
            tile.step = step;
            tile.refines = step != coarse_step;
            tiles.push_back(tile);
        }
        passes.push_back(std::move(tiles));
    }
    return passes;
}

}  // namespace terravox::tiles
