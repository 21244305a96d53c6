#include "raytracer/tiles/tile_plan.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "common/util/error.hpp"

namespace terravox {
namespace {

struct Cell {
    int column, row;
};

// From the middle outwards, ring by ring, clockwise: what people look at first comes first.
void sort_as_spiral(std::vector<Cell>& cells, int columns, int rows) {
    const auto key = [&](const Cell& c) {
        const double dx = c.column - (columns - 1) / 2.0, dy = c.row - (rows - 1) / 2.0;
        const double ring = std::max(std::abs(dx), std::abs(dy));
        return std::pair(ring, std::atan2(dy, dx));
    };
    std::stable_sort(cells.begin(), cells.end(), [&](const Cell& a, const Cell& b) { return key(a) < key(b); });
}

}  // namespace

std::vector<std::vector<RenderTile>> plan_tiles(int width_px, int height_px, int coarse_step, int tile_px, const std::string& order) {
    if (coarse_step < 1 || !std::has_single_bit(static_cast<unsigned>(coarse_step)))
        throw UsageError("plan the passes: quality.coarse_step = " + std::to_string(coarse_step) + "; allowed: 1, 2, 4, 8, 16, 32, 64");
    const int columns = (width_px + tile_px - 1) / tile_px, rows = (height_px + tile_px - 1) / tile_px;
    std::vector<Cell> cells;
    if (order == "vertical") {
        for (int c = 0; c < columns; ++c)
            for (int r = 0; r < rows; ++r) cells.push_back({c, r});
    } else {
        for (int r = 0; r < rows; ++r)
            for (int c = 0; c < columns; ++c) cells.push_back({c, r});
    }
    if (order == "spiral") sort_as_spiral(cells, columns, rows);

    std::vector<std::vector<RenderTile>> passes;
    for (int step = coarse_step; step >= 1; step /= 2) {
        std::vector<RenderTile> tiles;
        for (const Cell& c : cells) {
            RenderTile tile;
            tile.index = static_cast<std::uint32_t>(tiles.size());
            tile.pass = static_cast<std::uint32_t>(passes.size());
            tile.x0 = c.column * tile_px, tile.y0 = c.row * tile_px;
            tile.x1 = std::min(tile.x0 + tile_px, width_px), tile.y1 = std::min(tile.y0 + tile_px, height_px);
            tile.step = step;
            tile.refines = step != coarse_step;
            tiles.push_back(tile);
        }
        passes.push_back(std::move(tiles));
    }
    return passes;
}

}  // namespace terravox
