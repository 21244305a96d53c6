#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "raytracer/analyse/objects/feature_file.hpp"
#include "raytracer/analyse/objects/object_sums.hpp"
#include "raytracer/analyse/objects/polygon_cells.hpp"
#include "raytracer/analyse/raster/cell_file.hpp"

namespace terravox::analyse {

/// Facts of a GeoPackage of objects or facades that are not those of one of them.
struct ObjectFileInfo {
    output::GeoPlacement placement;  ///< of the raster; with a CRS
    std::string description;         ///< of the layer
};

/// @throws as check_feature_target()
void check_object_target(const std::filesystem::path& out);

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
