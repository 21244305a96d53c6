#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "voxelserver/imagery/colour_map.hpp"
#include "voxelserver/imagery/filters.hpp"
#include "voxelserver/imagery/raster.hpp"

namespace terravox::imagery {

/// The surfaces of a rectangle of columns as the LiDAR tells them; index = z * width + x in every
/// list.
struct SurfaceColumns {
    int width = 0, height = 0;  ///< with the margin
    int margin = 0;
    std::span<const Group> group;
    std::span<const voxel::Material> material;  ///< of the point's class; kAir where nothing is
    std::span<const std::uint8_t>
        covered;  ///< not 0: a crown, deck or wire hides the surface from above; empty = none is
    std::span<const voxel::Rgb8> point_colour;       ///< empty = the points have no colours
    std::span<const std::uint8_t> has_point_colour;  ///< empty exactly when point_colour is
};

/// Step "specialization": ground becomes grass, road, water ..., a roof becomes an orange, grey or
/// flat one, by the image's colour, else by the points'. Each column by itself. What is certain is
/// marked kFixed in the result: materials that a class names exactly (rail, road, water ...),
/// vegetation, bridges and objects. A column without a colour keeps the class's material, and so
/// does a covered one (an image shows what covers it); both are marked kSilent: the filters give
/// them their neighbours' material and do not ask them.
/// @param raster of the same rectangle; an empty one = no images
/// @throws Error when the sizes disagree
[[nodiscard]] Grid specialize(const SurfaceColumns& columns, const Raster& raster,
                              const ColourMap& map);

/// Which cells of `cell` x `cell` columns look wet: at least `share` of the columns that tell are
/// water. For water that a survey has no class for.
/// @param material, told  width x height columns each; `told` 0 = the column does not count (no
/// ground was seen), empty = all count that
///        are not kAir
/// @param cell [1, 4096] columns; the last cells may be narrower  @param min_told share of a
/// cell's columns that must tell, (0, 1]
/// @return row by row, ceil(width / cell) x ceil(height / cell); 1 = wet
/// @throws Error when the sizes disagree
[[nodiscard]] std::vector<std::uint8_t> looks_wet(std::span<const voxel::Material> material,
                                                  std::span<const std::uint8_t> told, int width,
                                                  int height, int cell, double share = 0.6,
                                                  double min_told = 0.25);

}  // namespace terravox::imagery
