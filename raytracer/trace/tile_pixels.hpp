#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "raytracer/tiles/tile.hpp"
#include "raytracer/trace/pixel_blocks.hpp"

namespace terravox::trace {

/// A pixel of the part of a tile that is being traced.
struct TilePixel {
    int x = 0;
    int y = 0;
    std::uint32_t place = 0;            ///< in the order of RenderTile::each_pixel
    const PixelBlock* block = nullptr;  ///< which it belongs to
};

/// The pixels of a tile in blocks of neighbours. They are traced part by part, so that the rays of
/// a large tile need no more memory than those of a small one.
class TilePixels {
public:
    /// Begins a tile; memory of the one before is used again.
    void start(const tiles::RenderTile& tile);
    /// Cuts the tile into blocks; it has no part yet. @return how many pixels it has
    std::size_t cut(const scene::Camera& camera, walk::BeamMarch& beams);
    /// The next blocks become the part that pixels() are of. @param max_blocks at least 1
    void next_part(std::size_t max_blocks);
    [[nodiscard]] bool is_last_part() const noexcept { return m_part_end == m_blocks.size(); }
    /// Of the part, block by block; valid until the next part.
    [[nodiscard]] std::span<const TilePixel> pixels() const noexcept { return m_pixels; }
    [[nodiscard]] const tiles::RenderTile& tile() const noexcept { return m_tile; }

private:
    [[nodiscard]] std::size_t lattice_index(int column, int row) const noexcept;
    void add_pixels(const PixelBlock& block);

    tiles::RenderTile m_tile;
    PixelLattice m_lattice;
    /// By lattice_index(): TilePixel::place; -1 where an earlier pass has the pixel.
    std::vector<std::int32_t> m_places;
    std::vector<PixelBlock> m_blocks;
    std::size_t m_part_end = 0;  ///< the first block behind the part
    std::vector<TilePixel> m_pixels;
};

}  // namespace terravox::trace
