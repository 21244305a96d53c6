#pragma once

#include "raytracer/core/base/ray.hpp"

namespace terravox::analyse {

/// Sums over the heights of a cell and of its neighbours, for the plane through them. Heights are
/// relative to the cell's and whole voxels, so the sums do not depend on the order.
struct HeightSums {
    float count = 0;
    float e = 0, s = 0, h = 0;  ///< steps to the east and to the south, height in voxels
    float ee = 0, es = 0, ss = 0, eh = 0, sh = 0, hh = 0;

    /// @param east, south steps of a cell
    /// @param height level-0 voxels above the cell
    void add(int east, int south, float height) noexcept;
};

/// Whether a neighbour belongs to the surface of a cell: what rises or falls more steeply than a
/// steep roof is another surface, such as a wall or the ground below the eaves.
/// @param distance to the neighbour, level-0 voxels
/// @param height of it above the cell, level-0 voxels
/// @param step edge of the voxels that heights are in, level-0 voxels
[[nodiscard]] bool is_same_surface(double distance, double height, double step) noexcept;

/// The surface of a cell as a plane.
struct CellPlane {
    double east = 0;   ///< rise per distance to the east
    double south = 0;  ///< rise per distance to the south
    /// How far above the cell's top a point lies that sees over the steps of the voxels along the
    /// plane, level-0 voxels; 0 on level ground.
    double lift = 0;

    [[nodiscard]] core::Vec3 normal() const noexcept;
};

/// The direction in which something looks, degrees clockwise from the map's north, [0, 360).
/// @param normal x east, z south; not vertical
[[nodiscard]] double azimuth_deg(core::Vec3 normal) noexcept;

/// The plane of least squares. Heights in one line, or fewer than three, give a level one.
/// @param spacing of the cells, level-0 voxels
/// @param step as above
[[nodiscard]] CellPlane plane_through(const HeightSums& sums, double spacing, double step) noexcept;

}  // namespace terravox::analyse
