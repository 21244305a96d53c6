#include "raytracer/analyse/objects/feature_file.hpp"

#include <ogr_api.h>
#include <ogr_geometry.h>
#include <ogr_spatialref.h>
#include <algorithm>
#include <cmath>

#include "common/geo/crs.hpp"
#include "common/geo/gdal_files.hpp"
#include "common/util/error.hpp"
#include "common/util/text.hpp"
#include "raytracer/analyse/report/band_style.hpp"

namespace terravox::analyse {
namespace {

constexpr int kSteps = 6;

/// Borders of the steps, whole numbers where the values allow it.
struct Steps {
    double low = 0;
    double width = 1;
    [[nodiscard]] double border(int i) const noexcept { return low + width * i; }
};

Steps make_steps(const std::vector<double>& kwh_m2) {
    const auto [first, last] = std::minmax_element(kwh_m2.begin(), kwh_m2.end());
    const double least = kwh_m2.empty() ? 0 : *first;
    const double most = kwh_m2.empty() ? 0 : *last;
    constexpr double kUneven = kSteps * 2;
    // Of a single day energies differ by less than the steps of whole numbers.
    const double unit = most - least > kUneven ? 1 : 0.01;
    Steps out;
    out.low = std::floor(least / unit) * unit;
    out.width = std::max(std::ceil((most - out.low) / kSteps / unit), 1.0) * unit;
    return out;
}

std::string make_range(const Steps& steps, int i) {
    const double low = steps.border(i);
    const double high = steps.border(i + 1);
    return fmt::format(
        "<range lower=\"{:.6f}\" upper=\"{:.6f}\" symbol=\"{}\" label=\"{:g} to {:g}\" "
        "render=\"true\"/>",
        low, high, i, low, high);
}

std::string make_symbol(int i, StyledShape shape) {
    const map::Rgba8 colour =
        colour_at(Ramp::kWarm, 0.25 + 0.75 * static_cast<double>(i) / (kSteps - 1));
    if (shape == StyledShape::kLine)
        return fmt::format(
            "<symbol type=\"line\" name=\"{}\" alpha=\"1\" clip_to_extent=\"1\">"
            "<layer class=\"SimpleLine\" enabled=\"1\" locked=\"0\" pass=\"0\">"
            "<prop k=\"line_color\" v=\"{},{},{},255\"/><prop k=\"line_width\" v=\"0.8\"/>"
            "</layer></symbol>",
            i, colour.r, colour.g, colour.b);
    return fmt::format(
        "<symbol type=\"fill\" name=\"{}\" alpha=\"0.8\" clip_to_extent=\"1\">"
        "<layer class=\"SimpleFill\" enabled=\"1\" locked=\"0\" pass=\"0\">"
        "<prop k=\"color\" v=\"{},{},{},255\"/><prop k=\"outline_color\" v=\"60,60,60,255\"/>"
        "<prop k=\"outline_width\" v=\"0.2\"/><prop k=\"style\" v=\"solid\"/></layer></symbol>",
        i, colour.r, colour.g, colour.b);
}

constexpr const char* kLabels =
    "<labeling type=\"simple\"><settings>"
    "<text-style fieldName=\"round(&quot;kwh&quot;) || ' kWh'\" isExpression=\"1\" "
    "fontSize=\"8\" textColor=\"30,30,30,255\">"
    "<text-buffer bufferDraw=\"1\" bufferSize=\"0.8\" "
    "bufferColor=\"255,255,255,220\"/></text-style>"
    "<placement placement=\"1\"/>"
    "<rendering scaleVisibility=\"1\" scaleMin=\"0\" scaleMax=\"5000\"/>"
    "</settings></labeling>";

}  // namespace

std::string qgis_style(const std::vector<double>& kwh_m2, StyledShape shape) {
    const Steps steps = make_steps(kwh_m2);
    std::string ranges;
    std::string symbols;
    for (int i = 0; i < kSteps; ++i) {
        ranges += make_range(steps, i);
        symbols += make_symbol(i, shape);
    }
    const bool has_labels = shape == StyledShape::kPolygon;
    return std::string(
               "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>"
               "<qgis version=\"3.22.0\" styleCategories=\"Symbology|Labeling\" "
               "labelsEnabled=\"") +
           (has_labels ? "1" : "0") +
           "\">"
           "<renderer-v2 type=\"graduatedSymbol\" attr=\"kwh_m2\" "
           "graduatedMethod=\"GraduatedColor\" symbollevels=\"0\" enableorderby=\"0\" "
           "forceraster=\"0\"><ranges>" +
           ranges + "</ranges><symbols>" + symbols + "</symbols></renderer-v2>" +
           (has_labels ? kLabels : "") + "</qgis>";
}

namespace {

constexpr const char* kGeometry = "geom";

void add_field(OGRLayerH layer, const FeatureField& from, const output::GdalWatch& watch) {
    OGRFieldDefnH field = OGR_Fld_Create(from.name, from.type);
    const OGRErr failed = OGR_L_CreateField(layer, field, TRUE);
    OGR_Fld_Destroy(field);
    watch.check(failed == OGRERR_NONE);
}

int compute_index(void* feature, const char* field) {
    return OGR_F_GetFieldIndex(feature, field);
}

}  // namespace

void Feature::Destroy::operator()(void* feature) const noexcept {
    OGR_F_Destroy(static_cast<OGRFeatureH>(feature));
}

void Feature::set(const char* field, double value) {
    OGR_F_SetFieldDouble(get(), compute_index(get(), field), value);
}

void Feature::set(const char* field, const char* value) {
    OGR_F_SetFieldString(get(), compute_index(get(), field), value);
}

void Feature::set_count(const char* field, std::uint64_t value) {
    OGR_F_SetFieldInteger64(get(), compute_index(get(), field), static_cast<GIntBig>(value));
}

std::int64_t Feature::count(const char* field) const {
    return OGR_F_GetFieldAsInteger64(get(), compute_index(get(), field));
}

void check_feature_target(const std::filesystem::path& out, const std::string& what) {
    const std::string ending = util::lower_extension(out);
    if (ending != ".gpkg")
        throw util::UsageError("write the " + what + " " + out.string() + ": the ending '" +
                               ending + "'; allowed: .gpkg");
    util::check_writable(out);
}

FeatureFile::FeatureFile(const std::filesystem::path& out, const std::string& what,
                         const output::GeoPlacement& placement, const FeatureLayer& layer)
    : m_attempt("write the " + what + " " + out.string()), m_layer_name(layer.name), m_file(out) {
    const output::GdalWatch watch(m_attempt);
    m_dataset.reset(GDALCreate(geo::geopackage_driver(), m_file.temporary_path().string().c_str(),
                               0, 0, 0, GDT_Unknown, nullptr));
    watch.check(m_dataset != nullptr);
    // One for all: each feature's own would wait for the disk.
    watch.check(GDALDatasetStartTransaction(m_dataset.get(), FALSE) == OGRERR_NONE);
    const geo::Crs crs = geo::Crs::from_wkt(placement.crs_wkt);
    output::GdalOptions options = {{"GEOMETRY_NAME", kGeometry},
                                   {"FID", "fid"},
                                   {"IDENTIFIER", layer.name},
                                   {"DESCRIPTION", layer.description}};
    m_layer = GDALDatasetCreateLayer(
        m_dataset.get(), layer.name,
        OGRSpatialReference::ToHandle(const_cast<OGRSpatialReference*>(&crs.ogr())), layer.geometry,
        options.List());
    watch.check(m_layer != nullptr);
    for (const FeatureField& field : layer.fields)
        add_field(static_cast<OGRLayerH>(m_layer), field, watch);
}

Feature FeatureFile::new_feature() const {
    return Feature(OGR_F_Create(OGR_L_GetLayerDefn(static_cast<OGRLayerH>(m_layer))));
}

void FeatureFile::add(Feature& feature, const OGRGeometry& geometry) {
    const output::GdalWatch watch(m_attempt);
    const OGRErr failed = OGR_F_SetGeometry(
        feature.get(), OGRGeometry::ToHandle(const_cast<OGRGeometry*>(&geometry)));
    watch.check(failed == OGRERR_NONE &&
                OGR_L_CreateFeature(static_cast<OGRLayerH>(m_layer), feature.get()) == OGRERR_NONE);
}

void FeatureFile::add_style(const LayerStyle& style) {
    const output::GdalWatch watch(m_attempt);
    output::GdalOptions options = {{"FID", "id"}};
    // The table in which QGIS keeps and looks for styles.
    const auto table = static_cast<OGRLayerH>(
        GDALDatasetCreateLayer(m_dataset.get(), "layer_styles", nullptr, wkbNone, options.List()));
    watch.check(table != nullptr);
    const FeatureField fields[] = {{"f_table_catalog", OFTString},
                                   {"f_table_schema", OFTString},
                                   {"f_table_name", OFTString},
                                   {"f_geometry_column", OFTString},
                                   {"styleName", OFTString},
                                   {"styleQML", OFTString},
                                   {"styleSLD", OFTString},
                                   {"useAsDefault", OFTInteger},
                                   {"description", OFTString},
                                   {"owner", OFTString},
                                   {"ui", OFTString},
                                   {"update_time", OFTDateTime}};
    for (const FeatureField& field : fields)
        add_field(table, field, watch);
    Feature row(OGR_F_Create(OGR_L_GetLayerDefn(table)));
    for (const char* name : {"f_table_catalog", "f_table_schema", "styleSLD", "owner", "ui"})
        row.set(name, "");
    row.set("f_table_name", m_layer_name.c_str());
    row.set("f_geometry_column", kGeometry);
    row.set("styleName", style.name);
    row.set("styleQML", style.qml.c_str());
    row.set("description", style.description);
    row.set_count("useAsDefault", 1);
    watch.check(OGR_L_CreateFeature(table, row.get()) == OGRERR_NONE);
}

void FeatureFile::finish(const LayerStyle& style) {
    add_style(style);
    const output::GdalWatch watch(m_attempt);
    watch.check(GDALDatasetCommitTransaction(m_dataset.get()) == OGRERR_NONE);
    m_dataset.reset();  // writes what is left
    watch.check(true);
    m_file.commit();
}

}  // namespace terravox::analyse
