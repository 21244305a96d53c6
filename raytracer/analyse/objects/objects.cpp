#include "raytracer/analyse/objects/objects.hpp"

#include <ogr_geometry.h>

#include "raytracer/analyse/objects/connected_cells.hpp"
#include "raytracer/analyse/objects/qgis_style.hpp"

namespace terravox::analyse {
namespace {

/// The numbers of buildings as a temporary raster next to the output.
class LabelFile {
public:
    LabelFile(const std::filesystem::path& out, ConnectedCells& found, int columns, int rows)
        : m_attempt("write the objects " + out.string()),
          m_file(std::filesystem::path(out).replace_extension(".labels.tif")) {
        const output::GdalWatch watch(m_attempt);
        output::GdalOptions options = {
            {"COMPRESS", "DEFLATE"}, {"ZLEVEL", "1"}, {"SPARSE_OK", "TRUE"}, {"BIGTIFF", "YES"}};
        m_dataset.reset(GDALCreate(GDALGetDriverByName("GTiff"),
                                   m_file.temporary_path().string().c_str(), columns, rows, 1,
                                   GDT_Int32, options.list()));
        watch.check(m_dataset != nullptr);
        GDALRasterBandH band = GDALGetRasterBand(m_dataset.get(), 1);
        found.each_row([&](int row, std::vector<std::int32_t>& numbers) {
            watch.check(GDALRasterIO(band, GF_Write, 0, row, columns, 1, numbers.data(), columns, 1,
                                     GDT_Int32, 0, 0) == CE_None);
        });
    }
    [[nodiscard]] GDALDatasetH dataset() const noexcept { return m_dataset.get(); }

private:
    const std::string m_attempt;
    util::AtomicFile m_file;  // outlives the dataset in it; never committed
    output::GdalDataset m_dataset;
};

}  // namespace

std::size_t write_objects(CellFile& cells, const std::filesystem::path& out,
                          const ObjectFileInfo& info, const std::vector<ObjectPolygon>& polygons,
                          double cell_m2, const std::stop_token& stop) {
    ObjectFile file(out, polygons.empty() ? Outlines::kCells : Outlines::kGiven, info);
    if (polygons.empty()) {
        ConnectedCells found(cells, cell_m2, stop);
        const LabelFile labels(out, found, cells.columns(), cells.rows());
        file.add_all(labels.dataset(), found.facts(), stop);
        file.finish(qgis_style(found.facts()));
        return found.facts().size();
    }
    const std::vector<ObjectFacts> facts = facts_of(cells, polygons, cell_m2, stop);
    for (std::size_t i = 0; i < polygons.size(); ++i)
        file.add(*polygons[i].outline, static_cast<std::int64_t>(polygons[i].feature) + 1,
                 facts[i]);
    file.finish(qgis_style(facts));
    return facts.size();
}

}  // namespace terravox::analyse
