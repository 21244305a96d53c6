#include "raytracer/core/trace/tile_pixels.hpp"

#include <algorithm>
#include <bit>

namespace terravox::trace {
namespace {

struct Cutter {
    const PixelLattice& lattice;
    const scene::Camera& camera;
    walk::BeamMarch& beams;
    std::vector<PixelBlock>& out;

    // The square of the lattice from (column, row) on, cut to it.
    void cut(int column, int row, int size, const walk::BeamStart& known) const {
        const int columns = std::min(size, lattice.columns - column);
        const int rows = std::min(size, lattice.rows - row);
        if (columns <= 0 || rows <= 0)
            return;
        const walk::BeamStart start = known.kind == walk::BeamStart::Kind::kMiss
                                          ? known
                                          : march(column, row, columns, rows, known);
        if (size <= kPixelBlockSide) {
            out.push_back({column, row, columns, rows, start});
            return;
        }
        const int half = size / 2;
        for (int quarter = 0; quarter < 4; ++quarter)
            cut(column + (quarter & 1) * half, row + (quarter >> 1) * half, half, start);
    }

    [[nodiscard]] walk::BeamStart march(int column, int row, int columns, int rows,
                                        const walk::BeamStart& known) const {
        if (!camera.pinhole())
            return known;
        const double x0 = lattice.first_x + column * lattice.step;
        const double y0 = lattice.first_y + row * lattice.step;
        const double x1 = x0 + (columns - 1) * lattice.step + 1;
        const double y1 = y0 + (rows - 1) * lattice.step + 1;
        const core::Vec3 corners[4] = {camera.ray(x0, y0).direction, camera.ray(x1, y0).direction,
                                       camera.ray(x0, y1).direction, camera.ray(x1, y1).direction};
        walk::Beam beam;
        return walk::Beam::make(camera.position(), corners, beam) ? beams.march(beam, known)
                                                                  : known;
    }
};

}  // namespace

void add_pixel_blocks(const PixelLattice& lattice, const scene::Camera& camera,
                      walk::BeamMarch& beams, std::vector<PixelBlock>& out) {
    const int size = std::max({lattice.columns, lattice.rows, 1});
    Cutter{lattice, camera, beams, out}.cut(
        0, 0, static_cast<int>(std::bit_ceil(static_cast<unsigned>(size))), {});
}

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
