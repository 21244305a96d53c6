#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "common/util/atomic_file.hpp"
#include "raytracer/analyse/objects/object_sums.hpp"
#include "raytracer/output/gdal_writing.hpp"
#include "raytracer/output/picture_info.hpp"

class OGRGeometry;

namespace terravox::analyse {

/// Facts of a GeoPackage of objects that are not those of one of them.
struct ObjectFileInfo {
    output::GeoPlacement placement;  ///< of the raster; with a CRS
    std::string description;         ///< of the layer
};

enum class Outlines : std::uint8_t {
    kCells,  ///< one polygon for each object, along its cells
    kGiven,  ///< one multipolygon for each
};

/// A GeoPackage with a layer of objects (docs/formats/objects.md) and its style for QGIS. It
/// appears under its name only when it is complete. Not thread-safe.
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
    void add_layer(Outlines outlines, const ObjectFileInfo& info);
    void add_style(const std::string& style);

    const std::string m_attempt;
    util::AtomicFile m_file;  // outlives the dataset in it
    std::array<double, 6> m_transform;
    output::GdalDataset m_dataset;
    void* m_layer = nullptr;  ///< OGRLayerH of m_dataset
};

/// @throws UsageError unless the file's name is that of a GeoPackage; Error when it cannot be
/// written
void check_object_target(const std::filesystem::path& out);

}  // namespace terravox::analyse
