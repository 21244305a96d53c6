#include "raytracer/analyse/objects/object_file.hpp"

#include <cpl_conv.h>
#include <gdal_alg.h>
#include <ogr_api.h>
#include <ogr_geometry.h>
#include <ogr_spatialref.h>

#include <cmath>

#include "common/geo/crs.hpp"
#include "common/geo/geopackage.hpp"
#include "common/util/error.hpp"
#include "common/util/letter_case.hpp"

namespace terravox::analyse {
namespace {

constexpr const char* kGeometry = "geom";

struct FeatureDestroy {
    void operator()(void* feature) const noexcept {
        OGR_F_Destroy(static_cast<OGRFeatureH>(feature));
    }
};
using Feature = std::unique_ptr<void, FeatureDestroy>;

struct Field {
    const char* name;
    OGRFieldType type;
};
constexpr Field kFields[] = {
    {"id", OFTInteger64},
    {"area_m2", OFTReal},
    {"surface_m2", OFTReal},
    {"kwh_m2", OFTReal},
    {"kwh", OFTReal},
    {"sun_hours", OFTReal},
    {"best_facing", OFTString},
    {"best_azimuth_deg", OFTReal},
    {"best_slope_deg", OFTReal},
    {"best_surface_m2", OFTReal},
    {"best_kwh_m2", OFTReal},
    {"best_kwh", OFTReal},
    {"cells", OFTInteger64},
    {"cells_without_value", OFTInteger64},
};

void add_field(OGRLayerH layer, const char* name, OGRFieldType type,
               const output::GdalWatch& watch) {
    OGRFieldDefnH field = OGR_Fld_Create(name, type);
    const OGRErr failed = OGR_L_CreateField(layer, field, TRUE);
    OGR_Fld_Destroy(field);
    watch.check(failed == OGRERR_NONE);
}

int index_of(OGRFeatureH feature, const char* name) {
    return OGR_F_GetFieldIndex(feature, name);
}
void set(OGRFeatureH feature, const char* name, double value) {
    OGR_F_SetFieldDouble(feature, index_of(feature, name), value);
}
void set(OGRFeatureH feature, const char* name, const char* value) {
    OGR_F_SetFieldString(feature, index_of(feature, name), value);
}
void set_count(OGRFeatureH feature, const char* name, std::uint64_t value) {
    OGR_F_SetFieldInteger64(feature, index_of(feature, name), static_cast<GIntBig>(value));
}

void set_facts(OGRFeatureH feature, const ObjectFacts& facts) {
    set(feature, "area_m2", facts.area_m2);
    set_count(feature, "cells", facts.cells);
    set_count(feature, "cells_without_value", facts.cells_without_value);
    if (!facts.has_values())
        return;
    set(feature, "surface_m2", facts.surface_m2);
    set(feature, "kwh_m2", facts.kwh_m2());
    set(feature, "kwh", facts.kwh);
    set(feature, "sun_hours", facts.sun_hours);
    set(feature, "best_facing", name_of(facts.best));
    if (facts.best != Facing::kFlat)
        set(feature, "best_azimuth_deg", facts.best_azimuth_deg);
    set(feature, "best_slope_deg", facts.best_slope_deg);
    set(feature, "best_surface_m2", facts.best_surface_m2);
    set(feature, "best_kwh_m2", facts.best_kwh / facts.best_surface_m2);
    set(feature, "best_kwh", facts.best_kwh);
}

/// A callback of GDAL's.
int CPL_STDCALL goes_on(double /*share*/, const char* /*message*/, void* stop) noexcept {
    return static_cast<const std::stop_token*>(stop)->stop_requested() ? FALSE : TRUE;
}

}  // namespace

void check_object_target(const std::filesystem::path& out) {
    const std::string ending = util::lower_extension(out);
    if (ending != ".gpkg")
        throw util::UsageError("write the objects " + out.string() + ": the ending '" + ending +
                               "'; allowed: .gpkg");
    util::check_writable(out);
}

ObjectFile::ObjectFile(const std::filesystem::path& out, Outlines outlines,
                       const ObjectFileInfo& info)
    : m_attempt("write the objects " + out.string()),
      m_file(out),
      m_transform(info.placement.transform) {
    const output::GdalWatch watch(m_attempt);
    m_dataset.reset(GDALCreate(geo::geopackage_driver(), m_file.temporary_path().string().c_str(),
                               0, 0, 0, GDT_Unknown, nullptr));
    watch.check(m_dataset != nullptr);
    // One for all: each feature's own would wait for the disk.
    watch.check(GDALDatasetStartTransaction(m_dataset.get(), FALSE) == OGRERR_NONE);
    add_layer(outlines, info);
}

void ObjectFile::add_layer(Outlines outlines, const ObjectFileInfo& info) {
    const output::GdalWatch watch(m_attempt);
    const geo::Crs crs = geo::Crs::from_wkt(info.placement.crs_wkt);
    output::GdalOptions options = {{"GEOMETRY_NAME", kGeometry},
                                   {"FID", "fid"},
                                   {"IDENTIFIER", kLayer},
                                   {"DESCRIPTION", info.description}};
    m_layer = GDALDatasetCreateLayer(
        m_dataset.get(), kLayer,
        OGRSpatialReference::ToHandle(const_cast<OGRSpatialReference*>(&crs.ogr())),
        outlines == Outlines::kGiven ? wkbMultiPolygon : wkbPolygon, options.list());
    watch.check(m_layer != nullptr);
    for (const Field& field : kFields)
        add_field(static_cast<OGRLayerH>(m_layer), field.name, field.type, watch);
}

void ObjectFile::add(const OGRGeometry& outline, std::int64_t id, const ObjectFacts& facts) {
    const output::GdalWatch watch(m_attempt);
    const auto layer = static_cast<OGRLayerH>(m_layer);
    const Feature feature(OGR_F_Create(OGR_L_GetLayerDefn(layer)));
    OGR_F_SetFieldInteger64(feature.get(), index_of(feature.get(), "id"), id);
    set_facts(feature.get(), facts);
    const OGRErr failed =
        OGR_F_SetGeometry(feature.get(), OGRGeometry::ToHandle(const_cast<OGRGeometry*>(&outline)));
    watch.check(failed == OGRERR_NONE && OGR_L_CreateFeature(layer, feature.get()) == OGRERR_NONE);
}

void ObjectFile::add_all(GDALDatasetH labels, const std::vector<ObjectFacts>& facts,
                         const std::stop_token& stop) {
    const output::GdalWatch watch(m_attempt);
    watch.check(GDALSetGeoTransform(labels, m_transform.data()) == CE_None);
    GDALRasterBandH band = GDALGetRasterBand(labels, 1);
    const auto layer = static_cast<OGRLayerH>(m_layer);
    std::stop_token told = stop;
    const CPLErr outlined = GDALPolygonize(band, band, layer, 0, nullptr, goes_on, &told);
    if (stop.stop_requested())
        throw util::Error("interrupted");
    watch.check(outlined == CE_None);
    const auto count = OGR_L_GetFeatureCount(layer, TRUE);
    if (count != static_cast<GIntBig>(facts.size()))
        throw util::Error(m_attempt + ": " + std::to_string(count) + " outlines of " +
                          std::to_string(facts.size()) + " objects");
    for (GIntBig number = 1; number <= count; ++number) {
        const Feature feature(OGR_L_GetFeature(layer, number));
        watch.check(feature != nullptr);
        const auto id = OGR_F_GetFieldAsInteger64(feature.get(), index_of(feature.get(), "id"));
        set_facts(feature.get(), facts.at(static_cast<std::size_t>(id) - 1));
        watch.check(OGR_L_SetFeature(layer, feature.get()) == OGRERR_NONE);
    }
}

void ObjectFile::add_style(const std::string& style) {
    const output::GdalWatch watch(m_attempt);
    output::GdalOptions options = {{"FID", "id"}};
    // The table in which QGIS keeps and looks for styles.
    const auto table = static_cast<OGRLayerH>(
        GDALDatasetCreateLayer(m_dataset.get(), "layer_styles", nullptr, wkbNone, options.list()));
    watch.check(table != nullptr);
    const Field fields[] = {{"f_table_catalog", OFTString},
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
    for (const Field& field : fields)
        add_field(table, field.name, field.type, watch);
    const Feature row(OGR_F_Create(OGR_L_GetLayerDefn(table)));
    for (const char* name : {"f_table_catalog", "f_table_schema", "styleSLD", "owner", "ui"})
        set(row.get(), name, "");
    set(row.get(), "f_table_name", kLayer);
    set(row.get(), "f_geometry_column", kGeometry);
    set(row.get(), "styleName", "energy");
    set(row.get(), "styleQML", style.c_str());
    set(row.get(), "description", "kWh/m2");
    set_count(row.get(), "useAsDefault", 1);
    watch.check(OGR_L_CreateFeature(table, row.get()) == OGRERR_NONE);
}

void ObjectFile::finish(const std::string& style) {
    add_style(style);
    const output::GdalWatch watch(m_attempt);
    watch.check(GDALDatasetCommitTransaction(m_dataset.get()) == OGRERR_NONE);
    m_dataset.reset();  // writes what is left
    watch.check(true);
    m_file.commit();
}

}  // namespace terravox::analyse
