#include "raytracer/apps/pmtiles/tile_address.hpp"

#include <utility>

namespace terravox::pmtiles {

std::uint64_t tile_id(const TileAddress& tile) noexcept {
    // As many tiles as all coarser zooms have: 1 + 4 + 16 + ...
    const std::uint64_t before = ((std::uint64_t{1} << (2 * tile.zoom)) - 1) / 3;
    std::uint64_t along = 0;
    std::uint32_t x = tile.column;
    std::uint32_t y = tile.row;
    // Quadrant by quadrant, from the whole square down to single tiles. The curve visits the
    // quadrants as a U; its first and last quarter are the curve, mirrored at a diagonal.
    for (int bit = tile.zoom - 1; bit >= 0; --bit) {
        const bool east = (x >> bit & 1) != 0;
        const bool south = (y >> bit & 1) != 0;
        const std::uint64_t quarter = east ? (south ? 2 : 3) : (south ? 1 : 0);
        along = along << 2 | quarter;
        if (!south && east) {
            x = ~x;
            y = ~y;
        }
        if (!south)
            std::swap(x, y);
    }
    return before + along;
}

}  // namespace terravox::pmtiles
