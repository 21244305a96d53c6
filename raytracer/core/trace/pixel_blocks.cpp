#include "raytracer/core/trace/pixel_blocks.hpp"

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

}  // namespace terravox::trace
