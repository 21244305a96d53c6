#pragma once

#include <vector>

#include "raytracer/core/scene/camera.hpp"
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

}  // namespace terravox::trace
