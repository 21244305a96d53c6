#pragma once

#include <filesystem>

#include "raytracer/analyse/objects/facade_sums.hpp"
#include "raytracer/analyse/objects/object_file.hpp"

namespace terravox::analyse {

/// Writes facades as a GeoPackage with the layer `facades` (docs/formats/objects.md): a feature for
/// each storey of a building's facade, with the lines of its faces on the map.
/// @return how many there are
/// @throws Error
std::size_t write_facades(const FacadeSums& sums, const std::filesystem::path& out,
                          const ObjectFileInfo& info);

}  // namespace terravox::analyse
