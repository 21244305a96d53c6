#pragma once

#include <ogr_core.h>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/util/atomic_file.hpp"
#include "raytracer/core/output/gdal_writing.hpp"
#include "raytracer/core/output/picture.hpp"

class OGRGeometry;

namespace terravox::analyse {

/// What the features of a styled layer are.
enum class StyledShape : std::uint8_t {
    kPolygon,  ///< labelled with their field kwh
    kLine,
};

/// A style of QGIS (QML) that colours features by their field kwh_m2, in steps from the least to
/// the most of them.
/// @param kwh_m2 of the features that have a value
[[nodiscard]] std::string qgis_style(const std::vector<double>& kwh_m2, StyledShape shape);

/// A field of the features of a layer.
struct FeatureField {
    const char* name;
    OGRFieldType type;
};

/// A layer of features.
struct FeatureLayer {
    const char* name;
    OGRwkbGeometryType geometry;
    std::string description;
    std::span<const FeatureField> fields;
};

/// How QGIS draws a layer.
struct LayerStyle {
    const char* name;
    const char* description;
    std::string qml;
};

/// A feature of a layer, with the fields that are set. Not thread-safe.
class Feature {
public:
    /// @param feature OGRFeatureH; nullptr: none. Owned.
    explicit Feature(void* feature) noexcept : m_feature(feature) {}

    [[nodiscard]] void* get() const noexcept { return m_feature.get(); }
    void set(const char* field, double value);
    void set(const char* field, const char* value);
    void set_count(const char* field, std::uint64_t value);
    [[nodiscard]] std::int64_t count(const char* field) const;

private:
    struct Destroy {
        void operator()(void* feature) const noexcept;
    };
    std::unique_ptr<void, Destroy> m_feature;
};

/// A GeoPackage with one layer of features and its style for QGIS. It appears under its name only
/// when it is complete. Not thread-safe.
class FeatureFile {
public:
    /// @param what it holds, for messages: "objects"
    /// @param placement with a CRS
    /// @throws Error when it cannot be written
    FeatureFile(const std::filesystem::path& out, const std::string& what,
                const output::GeoPlacement& placement, const FeatureLayer& layer);

    [[nodiscard]] const std::string& attempt() const noexcept { return m_attempt; }
    /// OGRLayerH, for what adds or reads features itself.
    [[nodiscard]] void* layer() const noexcept { return m_layer; }

    [[nodiscard]] Feature new_feature() const;
    /// @throws Error
    void add(Feature& feature, const OGRGeometry& geometry);
    /// @throws Error
    void finish(const LayerStyle& style);

private:
    void add_style(const LayerStyle& style);

    const std::string m_attempt;
    const std::string m_layer_name;
    util::AtomicFile m_file;  // outlives the dataset in it
    output::GdalDataset m_dataset;
    void* m_layer = nullptr;
};

/// @param what as above
/// @throws UsageError unless the file's name is that of a GeoPackage; Error when it cannot be
/// written
void check_feature_target(const std::filesystem::path& out, const std::string& what);

}  // namespace terravox::analyse
