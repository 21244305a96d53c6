#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "raytracer/core/scene/camera.hpp"
#include "raytracer/core/tiles/tile.hpp"
#include "raytracer/core/walk/beam.hpp"

namespace terravox::trace {

/// Pixels `step` apart, columns x rows of them, starting with the pixel (first_x, first_y).
struct PixelLattice {
    int first_x = 0;
    int first_y = 0;
    int step = 1;
    int columns = 0;
    int rows = 0;
};

/// Up to 4 x 4 neighbours of a lattice, and where all rays through them may start.
struct PixelBlock {
    int column = 0;
    int row = 0;
    int columns = 0;
    int rows = 0;
    walk::BeamStart start;
};
inline constexpr int kPixelBlockSide = 4;  ///< with smaller blocks a beam costs more than it spares

/// Cuts a lattice into blocks along a Z-order curve, with beams from large to small: what is known
/// of a large beam saves work for the small ones.
void add_pixel_blocks(const PixelLattice& lattice, const scene::Camera& camera,
                      walk::BeamMarch& beams, std::vector<PixelBlock>& out);

/// A pixel of the part of a tile that is being traced.
struct TilePixel {
    int x = 0;
    int y = 0;
    std::uint32_t place = 0;            ///< index in the order of RenderTile::each_pixel
    const PixelBlock* block = nullptr;  ///< that it belongs to
};

/// The pixels of a tile in blocks of neighbours. They are traced part by part, so that the rays of
/// a large tile need no more memory than those of a small one.
class TilePixels {
public:
    /// Begins a tile; memory of the previous one is reused.
    void start(const tiles::RenderTile& tile);
    /// Cuts the tile into blocks; there is no part yet.
    /// @return its number of pixels
    std::size_t cut(const scene::Camera& camera, walk::BeamMarch& beams);
    /// Makes the next blocks the part that pixels() returns.
    /// @param max_blocks at least 1
    void next_part(std::size_t max_blocks);
    [[nodiscard]] bool is_last_part() const noexcept { return m_part_end == m_blocks.size(); }
    /// Pixels of the part, block by block; valid until the next part.
    [[nodiscard]] std::span<const TilePixel> pixels() const noexcept { return m_pixels; }
    [[nodiscard]] const tiles::RenderTile& tile() const noexcept { return m_tile; }

private:
    [[nodiscard]] std::size_t lattice_index(int column, int row) const noexcept;
    void add_pixels(const PixelBlock& block);

    tiles::RenderTile m_tile;
    PixelLattice m_lattice;
    /// TilePixel::place by lattice_index(); -1 where an earlier pass has the pixel.
    std::vector<std::int32_t> m_places;
    std::vector<PixelBlock> m_blocks;
    std::size_t m_part_end = 0;  ///< index of the first block after the part
    std::vector<TilePixel> m_pixels;
};

}  // namespace terravox::trace
