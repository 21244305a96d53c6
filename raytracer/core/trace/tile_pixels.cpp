#include "raytracer/core/trace/tile_pixels.hpp"

#include <algorithm>

namespace terravox::trace {

void TilePixels::start(const tiles::RenderTile& tile) {
    m_tile = tile;
    m_part_end = 0;
    m_blocks.clear();
    m_pixels.clear();
    const auto first = [&](int v) { return (v + tile.step - 1) / tile.step * tile.step; };
    const auto count = [&](int begin, int end) {
        return std::max((end - begin + tile.step - 1) / tile.step, 0);
    };
    m_lattice.first_x = first(tile.x0);
    m_lattice.first_y = first(tile.y0);
    m_lattice.step = tile.step;
    m_lattice.columns = count(m_lattice.first_x, tile.x1);
    m_lattice.rows = count(m_lattice.first_y, tile.y1);
}

std::size_t TilePixels::lattice_index(int column, int row) const noexcept {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(m_lattice.columns) +
           static_cast<std::size_t>(column);
}

std::size_t TilePixels::cut(const scene::Camera& camera, walk::BeamMarch& beams) {
    m_places.assign(
        static_cast<std::size_t>(m_lattice.columns) * static_cast<std::size_t>(m_lattice.rows), -1);
    std::int32_t count = 0;
    m_tile.each_pixel([&](int x, int y) {
        const int column = (x - m_lattice.first_x) / m_tile.step;
        const int row = (y - m_lattice.first_y) / m_tile.step;
        m_places[lattice_index(column, row)] = count++;
    });
    add_pixel_blocks(m_lattice, camera, beams, m_blocks);
    return static_cast<std::size_t>(count);
}

void TilePixels::next_part(std::size_t max_blocks) {
    const std::size_t begin = m_part_end;
    m_part_end = std::min(begin + max_blocks, m_blocks.size());
    m_pixels.clear();
    for (std::size_t i = begin; i < m_part_end; ++i)
        add_pixels(m_blocks[i]);
}

void TilePixels::add_pixels(const PixelBlock& block) {
    for (int row = block.row; row < block.row + block.rows; ++row)
        for (int column = block.column; column < block.column + block.columns; ++column) {
            const std::int32_t place = m_places[lattice_index(column, row)];
            if (place < 0)
                continue;
            TilePixel pixel;
            pixel.x = m_lattice.first_x + column * m_tile.step;
            pixel.y = m_lattice.first_y + row * m_tile.step;
            pixel.place = static_cast<std::uint32_t>(place);
            pixel.block = &block;
            m_pixels.push_back(pixel);
        }
}

}  // namespace terravox::trace
