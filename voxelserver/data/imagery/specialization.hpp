#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "voxelserver/data/imagery/colour_map.hpp"
#include "voxelserver/data/imagery/filters.hpp"
#include "voxelserver/data/imagery/raster.hpp"

namespace terravox::imagery {

/// The surfaces of a rectangle of columns as classified by the LiDAR data; index = z * width + x in
/// every list.
struct SurfaceColumns {
    int width = 0, height = 0;  ///< including the margin
    int margin = 0;
    std::span<const Group> group;
    /// By the point's class; kAir where there is nothing.
    std::span<const voxel::Material> material;
    /// Not 0: a crown, deck or wire hides the surface from above; empty = none is hidden.
    std::span<const std::uint8_t> covered;
    std::span<const voxel::Rgb8> point_colour;       ///< empty = the points have no colours
    std::span<const std::uint8_t> has_point_colour;  ///< empty if and only if point_colour is
};

/// Step "specialization": refines materials by colour, taken from the image, else from the points:
/// ground becomes grass, road, water ..., a roof becomes an orange, grey or flat one. Each column
/// is processed independently. Columns whose material is certain are marked kFixed in the result:
/// materials that a class names exactly (rail, road, water ...), vegetation, bridges and objects. A
/// column without a colour keeps the class's material, and so does a covered one (an image shows
/// the object above it); both are marked kSilent: the filters assign them their neighbours'
/// material but do not count their votes.
/// @param raster of the same rectangle; empty = no images
/// @throws Error when the sizes are inconsistent
[[nodiscard]] Grid specialize(const SurfaceColumns& columns, const Raster& raster,
                              const ColourMap& map);

/// Finds cells of `cell` x `cell` columns that look wet: at least `share` of their valid columns
/// are water. For water bodies in surveys without a class for water.
/// @param material, valid  width x height columns each; `valid` 0 = the column is not valid (no
/// ground was seen), empty = all columns except kAir are valid
/// @param cell [1, 4096] columns; the last cells may be narrower
/// @param min_valid minimum share of a cell's columns that must be valid, (0, 1]
/// @return row by row, ceil(width / cell) x ceil(height / cell); 1 = wet
/// @throws Error when the sizes are inconsistent
[[nodiscard]] std::vector<std::uint8_t> looks_wet(std::span<const voxel::Material> material,
                                                  std::span<const std::uint8_t> reported, int width,
                                                  int height, int cell, double share = 0.6,
                                                  double min_valid = 0.25);

}  // namespace terravox::imagery
