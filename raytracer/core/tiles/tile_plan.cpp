#include "raytracer/core/tiles/tile_plan.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "common/util/error.hpp"

namespace terravox::tiles {
namespace {

struct Grid {
    std::int32_t columns;
    std::int32_t rows;
};

std::vector<TileCell> make_rows(const Grid& g) {
    std::vector<TileCell> cells;
    cells.reserve(static_cast<std::size_t>(g.columns) * static_cast<std::size_t>(g.rows));
    for (std::int32_t r = 0; r < g.rows; ++r)
        for (std::int32_t c = 0; c < g.columns; ++c)
            cells.push_back({c, r});
    return cells;
}

/// Sorts by a key that no two cells share, computed once a cell.
template <class ToKey>
std::vector<TileCell> sorted_by(const Grid& g, const ToKey& to_key) {
    using Entry = std::pair<decltype(to_key(TileCell{})), TileCell>;
    std::vector<Entry> entries;
    std::vector<TileCell> cells = make_rows(g);
    entries.reserve(cells.size());
    for (const TileCell& cell : cells)
        entries.emplace_back(to_key(cell), cell);
    std::sort(entries.begin(), entries.end(),
              [](const Entry& a, const Entry& b) { return a.first < b.first; });
    std::transform(entries.begin(), entries.end(), cells.begin(),
                   [](const Entry& e) { return e.second; });
    return cells;
}

std::vector<TileCell> vertical(const Grid& g) {
    return sorted_by(g, [](const TileCell& c) { return std::pair(c.column, c.row); });
}

// The sky above is cheap and the land below expensive: in turns, all processors always have some of
// both.
std::vector<TileCell> vertical_split(const Grid& g) {
    const std::int32_t upper = (g.rows + 1) / 2;
    return sorted_by(g, [&](const TileCell& c) {
        return std::pair(c.column, c.row < upper ? 2 * c.row : 2 * (c.row - upper) + 1);
    });
}

// The middle, which is looked at first, is traced first. Distances from the middle are counted in
// half cells, so that they are whole numbers.
std::vector<TileCell> spiral(const Grid& g) {
    return sorted_by(g, [&](const TileCell& c) {
        const std::int32_t x = 2 * c.column - (g.columns - 1);
        const std::int32_t y = 2 * c.row - (g.rows - 1);
        const std::int32_t ring = std::max(std::abs(x), std::abs(y));
        // How far along the ring, clockwise from its upper left corner; each side is 2 rings long.
        const std::int32_t along = y == -ring  ? ring + x
                                   : x == ring ? 3 * ring + y
                                   : y == ring ? 5 * ring - x
                                               : 7 * ring - y;
        return std::pair(ring, along);
    });
}

/// How far along the Hilbert curve through a square of 2^bits cells' edge a cell lies.
///
/// The curve goes through four quarters in the order upper left, lower left, lower right, upper
/// right; in the first and the last it is mirrored, once at each diagonal. From the largest quarter
/// to the smallest: which one is it, and where is the cell in it? Ref: Hilbert, "Ueber die stetige
/// Abbildung einer Linie auf ein Flaechenstueck", Mathematische Annalen 38, 1891.
std::uint64_t along_hilbert(TileCell cell, int bits) {
    constexpr std::array<std::array<std::uint64_t, 2>, 2> kQuarter = {
        {{0, 1}, {3, 2}}};  // [right][lower]
    std::uint64_t along = 0;
    for (int bit = bits - 1; bit >= 0; --bit) {
        const std::int32_t edge = std::int32_t{1} << bit;
        const bool right = (cell.column & edge) != 0;
        const bool lower = (cell.row & edge) != 0;
        along = along << 2 | kQuarter[right ? 1 : 0][lower ? 1 : 0];
        cell.column &= edge - 1;
        cell.row &= edge - 1;
        if (lower)
            continue;
        if (right)
            cell = {edge - 1 - cell.column, edge - 1 - cell.row};
        std::swap(cell.column, cell.row);
    }
    return along;
}

std::vector<TileCell> hilbert(const Grid& g) {
    const int bits = std::bit_width(static_cast<std::uint32_t>(std::max(g.columns, g.rows) - 1));
    return sorted_by(g, [&](const TileCell& c) { return along_hilbert(c, bits); });
}

}  // namespace

std::vector<TileCell> order_cells(int columns, int rows, core::TileOrder order) {
    const Grid grid{columns, rows};
    switch (order) {
        case core::TileOrder::kSpiral: return spiral(grid);
        case core::TileOrder::kVertical: return vertical(grid);
        case core::TileOrder::kVerticalSplit: return vertical_split(grid);
        case core::TileOrder::kHilbert: return hilbert(grid);
        case core::TileOrder::kRows: break;
    }
    return make_rows(grid);
}

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
