#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "raytracer/analyse/objects/feature_file.hpp"
#include "raytracer/analyse/objects/object_sums.hpp"

namespace terravox::analyse {

/// Facts of a GeoPackage of objects or facades that are not those of one of them.
struct ObjectFileInfo {
    output::GeoPlacement placement;  ///< of the raster; with a CRS
    std::string description;         ///< of the layer
};

enum class Outlines : std::uint8_t {
    kCells,  ///< one polygon for each object, along its cells
    kGiven,  ///< one multipolygon for each
};

/// A GeoPackage with a layer of objects (docs/formats/objects.md). Not thread-safe.
class ObjectFile {
public:
    static constexpr const char* kLayer = "objects";

    /// @throws Error when it cannot be written
    ObjectFile(const std::filesystem::path& out, Outlines outlines, const ObjectFileInfo& info);

    /// Adds an object with its outline, of Outlines::kGiven.
    /// @throws Error
    void add(const OGRGeometry& outline, std::int64_t id, const ObjectFacts& facts);
    /// Adds all objects of Outlines::kCells.
    /// @param labels Int32, without CRS and place: numbers of objects from 1, 0 for other cells
    /// @param facts by number
    /// @throws Error; "interrupted" when stopped
    void add_all(GDALDatasetH labels, const std::vector<ObjectFacts>& facts,
                 const std::stop_token& stop);
    /// @param style QML
    /// @throws Error
    void finish(const std::string& style);

private:
    std::array<double, 6> m_transform;
    FeatureFile m_file;
};

/// @throws as check_feature_target()
void check_object_target(const std::filesystem::path& out);

}  // namespace terravox::analyse
