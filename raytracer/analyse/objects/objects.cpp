#include "raytracer/analyse/objects/objects.hpp"

#include <ogr_geometry.h>

#include "raytracer/analyse/objects/connected_cells.hpp"
#include "raytracer/analyse/objects/label_file.hpp"
#include "raytracer/analyse/objects/qgis_style.hpp"

namespace terravox::analyse {
namespace {

/// Of the objects that have a value.
std::vector<double> energies_of(const std::vector<ObjectFacts>& objects) {
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
        file.finish(qgis_style(energies_of(found.facts()), StyledShape::kPolygon));
        return found.facts().size();
    }
    const std::vector<ObjectFacts> facts = facts_of(cells, polygons, cell_m2, stop);
    for (std::size_t i = 0; i < polygons.size(); ++i)
        file.add(*polygons[i].outline, static_cast<std::int64_t>(polygons[i].feature) + 1,
                 facts[i]);
    file.finish(qgis_style(energies_of(facts), StyledShape::kPolygon));
    return facts.size();
}

}  // namespace terravox::analyse
