#include "raytracer/analyse/objects/feature_file.hpp"

#include <ogr_api.h>
#include <ogr_geometry.h>
#include <ogr_spatialref.h>

#include "common/geo/crs.hpp"
#include "common/geo/writing_drivers.hpp"
#include "common/util/error.hpp"
#include "common/util/letter_case.hpp"

namespace terravox::analyse {
namespace {

constexpr const char* kGeometry = "geom";

void add_field(OGRLayerH layer, const FeatureField& from, const output::GdalWatch& watch) {
    OGRFieldDefnH field = OGR_Fld_Create(from.name, from.type);
    const OGRErr failed = OGR_L_CreateField(layer, field, TRUE);
    OGR_Fld_Destroy(field);
    watch.check(failed == OGRERR_NONE);
}

int index_of(void* feature, const char* field) {
    return OGR_F_GetFieldIndex(feature, field);
}

}  // namespace

void Feature::Destroy::operator()(void* feature) const noexcept {
    OGR_F_Destroy(static_cast<OGRFeatureH>(feature));
}

void Feature::set(const char* field, double value) {
    OGR_F_SetFieldDouble(get(), index_of(get(), field), value);
}

void Feature::set(const char* field, const char* value) {
    OGR_F_SetFieldString(get(), index_of(get(), field), value);
}

void Feature::set_count(const char* field, std::uint64_t value) {
    OGR_F_SetFieldInteger64(get(), index_of(get(), field), static_cast<GIntBig>(value));
}

std::int64_t Feature::count(const char* field) const {
    return OGR_F_GetFieldAsInteger64(get(), index_of(get(), field));
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
        options.list());
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
        GDALDatasetCreateLayer(m_dataset.get(), "layer_styles", nullptr, wkbNone, options.list()));
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
