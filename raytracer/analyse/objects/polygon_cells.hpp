#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "raytracer/analyse/objects/object_sums.hpp"
#include "raytracer/analyse/raster/cell_file.hpp"
#include "raytracer/output/picture_info.hpp"
#include "voxelserver/worlds/overlay/footprint.hpp"

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
/// @throws Error as geo::read_geojson(); for what is no polygon, crosses itself or is not closed;
/// when none meets the raster
[[nodiscard]] std::vector<ObjectPolygon> read_polygons(const std::filesystem::path& file,
                                                       const output::GeoPlacement& to, int columns,
                                                       int rows);

/// Adds up the cells whose middles lie in each polygon, with those beyond the raster, which have no
/// value. A cell counts for all polygons that it lies in.
/// @return as many as there are polygons
/// @throws Error as CellFile; "interrupted" when stopped
[[nodiscard]] std::vector<ObjectFacts> facts_of(CellFile& cells,
                                                const std::vector<ObjectPolygon>& polygons,
                                                double cell_m2, const std::stop_token& stop);

}  // namespace terravox::analyse
