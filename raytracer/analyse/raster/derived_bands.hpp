#pragma once

#include <functional>
#include <stop_token>

#include "raytracer/analyse/raster/cell_file.hpp"

namespace terravox::analyse {

/// The surface whose slope, aspect and hillshade are wanted.
enum class ReliefOf : bool { kGround, kSurface };

struct ReliefOptions {
    ReliefOf of = ReliefOf::kGround;
    int window = 5;       ///< edge of the window of slopes, cells: odd
    double fill_m = 100;  ///< how far the ground is interpolated below buildings; 0: not at all
    double light_azimuth_deg = 315;
    double light_altitude_deg = 45;
};

/// Computes the terrain's bands that depend on neighbours: the ground below buildings, heights
/// above it, slope, aspect, hillshade. Block by block, each with the cells around that it needs.
/// @param edge_m of a cell
/// @throws Error "interrupted" when stopped, and as CellFile
void derive_terrain(CellFile& cells, double edge_m, const ReliefOptions& options,
                    const std::stop_token& stop);

}  // namespace terravox::analyse
