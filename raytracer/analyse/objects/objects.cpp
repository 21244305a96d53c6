#include "raytracer/analyse/objects/objects.hpp"

#include <gdal_alg.h>
#include <ogr_api.h>
#include <ogr_geometry.h>

#include "common/util/error.hpp"
#include "raytracer/analyse/objects/cell_labels.hpp"

namespace terravox::analyse {
namespace {

constexpr FeatureField kFields[] = {
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

void set_facts(Feature& feature, const ObjectFacts& facts) {
    feature.set("area_m2", facts.area_m2);
    feature.set_count("cells", facts.cells);
    feature.set_count("cells_without_value", facts.cells_without_value);
    if (!facts.has_values())
        return;
    feature.set("surface_m2", facts.surface_m2);
    feature.set("kwh_m2", facts.kwh_m2());
    feature.set("kwh", facts.kwh);
    feature.set("sun_hours", facts.sun_hours);
    feature.set("best_facing", to_name(facts.best));
    if (facts.best != Facing::kFlat)
        feature.set("best_azimuth_deg", facts.best_azimuth_deg);
    feature.set("best_slope_deg", facts.best_slope_deg);
    feature.set("best_surface_m2", facts.best_surface_m2);
    feature.set("best_kwh_m2", facts.best_kwh / facts.best_surface_m2);
    feature.set("best_kwh", facts.best_kwh);
}

/// A callback of GDAL's.
int CPL_STDCALL goes_on(double /*share*/, const char* /*message*/, void* stop) noexcept {
    return static_cast<const std::stop_token*>(stop)->stop_requested() ? FALSE : TRUE;
}

}  // namespace

void check_object_target(const std::filesystem::path& out) {
    check_feature_target(out, "objects");
}

namespace {

enum class Outlines : std::uint8_t {
    kCells,  ///< one polygon for each object, along its cells
    kGiven,  ///< one multipolygon for each
};

/// A GeoPackage with a layer of objects (docs/formats/objects.md). Not thread-safe.
class ObjectFile {
public:
    static constexpr const char* kLayer = "objects";

    /// @throws Error when it cannot be written
    ObjectFile(const std::filesystem::path& out, Outlines outlines, const ObjectFileInfo& info)
        : m_transform(info.placement.transform),
          m_file(out, "objects", info.placement,
                 {kLayer, outlines == Outlines::kGiven ? wkbMultiPolygon : wkbPolygon,
                  info.description, kFields}) {}

    /// Adds an object with its outline, of Outlines::kGiven.
    /// @throws Error
    void add(const OGRGeometry& outline, std::int64_t id, const ObjectFacts& facts) {
        Feature feature = m_file.new_feature();
        feature.set_count("id", static_cast<std::uint64_t>(id));
        set_facts(feature, facts);
        m_file.add(feature, outline);
    }
    /// Adds all objects of Outlines::kCells.
    /// @param labels Int32, without CRS and place: numbers of objects from 1, 0 for other cells
    /// @param facts by number
    /// @throws Error; "interrupted" when stopped
    void add_all(GDALDatasetH labels, const std::vector<ObjectFacts>& facts,
                 const std::stop_token& stop) {
        const output::GdalWatch watch(m_file.attempt());
        watch.check(GDALSetGeoTransform(labels, m_transform.data()) == CE_None);
        GDALRasterBandH band = GDALGetRasterBand(labels, 1);
        const auto layer = static_cast<OGRLayerH>(m_file.layer());
        std::stop_token told = stop;
        const CPLErr outlined = GDALPolygonize(band, band, layer, 0, nullptr, goes_on, &told);
        if (stop.stop_requested())
            throw util::Error("interrupted");
        watch.check(outlined == CE_None);
        const auto count = OGR_L_GetFeatureCount(layer, TRUE);
        if (count != static_cast<GIntBig>(facts.size()))
            throw util::Error(m_file.attempt() + ": " + std::to_string(count) + " outlines of " +
                              std::to_string(facts.size()) + " objects");
        for (GIntBig number = 1; number <= count; ++number) {
            Feature feature(OGR_L_GetFeature(layer, number));
            watch.check(feature.get() != nullptr);
            set_facts(feature, facts.at(static_cast<std::size_t>(feature.count("id")) - 1));
            watch.check(OGR_L_SetFeature(layer, feature.get()) == OGRERR_NONE);
        }
    }
    /// @param style QML
    /// @throws Error
    void finish(const std::string& style) { m_file.finish({"energy", "kWh/m2", style}); }

private:
    std::array<double, 6> m_transform;
    FeatureFile m_file;
};

/// Of the objects that have a value.
std::vector<double> list_energies(const std::vector<ObjectFacts>& objects) {
    std::vector<double> out;
    for (const ObjectFacts& object : objects)
        if (object.has_values())
            out.push_back(object.kwh_m2());
    return out;
}

}  // namespace

std::size_t write_objects(CellFile& cells, const std::filesystem::path& out,
                          const ObjectFileInfo& info, const std::vector<ObjectPolygon>& polygons,
                          double cell_m2, const std::stop_token& stop) {
    ObjectFile file(out, polygons.empty() ? Outlines::kCells : Outlines::kGiven, info);
    if (polygons.empty()) {
        ConnectedCells found(cells, cell_m2, stop);
        const LabelFile labels(out, found, cells.columns(), cells.rows());
        file.add_all(labels.dataset(), found.facts(), stop);
        file.finish(qgis_style(list_energies(found.facts()), StyledShape::kPolygon));
        return found.facts().size();
    }
    const std::vector<ObjectFacts> facts = collect_facts(cells, polygons, cell_m2, stop);
    for (std::size_t i = 0; i < polygons.size(); ++i)
        file.add(*polygons[i].outline, static_cast<std::int64_t>(polygons[i].feature) + 1,
                 facts[i]);
    file.finish(qgis_style(list_energies(facts), StyledShape::kPolygon));
    return facts.size();
}

}  // namespace terravox::analyse
