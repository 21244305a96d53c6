#pragma once

#include <filesystem>
#include <stop_token>
#include <vector>

#include "raytracer/analyse/objects/object_file.hpp"
#include "raytracer/analyse/objects/polygon_cells.hpp"
#include "raytracer/analyse/raster/cell_file.hpp"

namespace terravox::analyse {

/// The objects of a finished raster of AnalysisKind::kEnergy as a GeoPackage: its buildings, or the
/// polygons given. A function of the raster's values alone, of which some rows are in memory at a
/// time.
/// @param polygons empty: the raster's buildings
/// @param cell_m2 of a cell
/// @return how many there are
/// @throws Error; "interrupted" when stopped
std::size_t write_objects(CellFile& cells, const std::filesystem::path& out,
                          const ObjectFileInfo& info, const std::vector<ObjectPolygon>& polygons,
                          double cell_m2, const std::stop_token& stop);

}  // namespace terravox::analyse
