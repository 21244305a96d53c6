#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "raytracer/core/tiles/tile.hpp"

namespace terravox::farm {

/// The tiles of a picture of a single pass, numbered row by row from the upper left. The numbers,
/// called *cells*, do not depend on the order of rendering.
struct TileGrid {
    int width_px = 1, height_px = 1, tile_px = 1;  ///< each at least 1

    [[nodiscard]] std::uint32_t columns() const noexcept {
        return static_cast<std::uint32_t>((width_px + tile_px - 1) / tile_px);
    }
    [[nodiscard]] std::uint32_t rows() const noexcept {
        return static_cast<std::uint32_t>((height_px + tile_px - 1) / tile_px);
    }
    [[nodiscard]] std::uint32_t cells() const noexcept { return columns() * rows(); }

    /// @return nullopt for anything but a whole tile of a single pass with a pixel's first samples
    [[nodiscard]] std::optional<std::uint32_t> cell_of(const tiles::RenderTile& t) const noexcept {
        const bool whole = t.step == 1 && !t.refines && t.first_sample == 0 && t.x0 >= 0 &&
                           t.y0 >= 0 && t.x0 < width_px && t.y0 < height_px &&
                           t.x0 % tile_px == 0 && t.y0 % tile_px == 0 &&
                           t.x1 == std::min(t.x0 + tile_px, width_px) &&
                           t.y1 == std::min(t.y0 + tile_px, height_px);
        if (!whole)
            return std::nullopt;
        return static_cast<std::uint32_t>(t.y0 / tile_px) * columns() +
               static_cast<std::uint32_t>(t.x0 / tile_px);
    }
    friend bool operator==(const TileGrid&, const TileGrid&) = default;
};

}  // namespace terravox::farm
