#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <stop_token>
#include <vector>

#include "raytracer/analyse/objects/object_sums.hpp"
#include "raytracer/analyse/raster/cell_file.hpp"
#include "raytracer/core/output/picture.hpp"
#include "voxelserver/make/worlds/overlay/footprint.hpp"

class OGRMultiPolygon;

namespace terravox::analyse {

/// An object whose outline is given.
struct ObjectPolygon {
    std::size_t feature = 0;                         ///< its number in the file, from 0
    std::shared_ptr<const OGRMultiPolygon> outline;  ///< in the CRS of the raster
    std::vector<overlay::Footprint> parts;           ///< the same in cells of the raster
};

/// Reads the polygons of a GeoJSON file, one for each feature that has any.
/// @param to where the raster lies; with a CRS
/// @param columns, rows of the raster
/// @throws Error as geo::read_geojson(); for what is no polygon, crosses itself, is not closed, or
/// has a corner farther than 10^9 cells from the raster; when none meets the raster
[[nodiscard]] std::vector<ObjectPolygon> read_polygons(const std::filesystem::path& file,
                                                       const output::GeoPlacement& to, int columns,
                                                       int rows);

/// The cells whose middles a part of a polygon may hold, within a raster.
[[nodiscard]] CellRectangle cells_around(const overlay::Footprint& part, int columns, int rows);

/// Adds up the cells whose middles lie in each polygon. A cell counts for all polygons that it lies
/// in. Where a polygon reaches beyond the raster, its area there is as many cells without a value,
/// rounded: what a polygon costs depends on the raster and on its corners, not on where they lie.
/// @return as many as there are polygons
/// @throws Error as CellFile; "interrupted" when stopped
[[nodiscard]] std::vector<ObjectFacts> collect_facts(CellFile& cells,
                                                     const std::vector<ObjectPolygon>& polygons,
                                                     double cell_m2, const std::stop_token& stop);

}  // namespace terravox::analyse
