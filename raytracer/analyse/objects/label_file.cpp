#include "raytracer/analyse/objects/label_file.hpp"

#include <cstdint>
#include <vector>

namespace terravox::analyse {

LabelFile::LabelFile(const std::filesystem::path& out, ConnectedCells& found, int columns, int rows)
    : m_attempt("number the buildings for " + out.string()),
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

}  // namespace terravox::analyse
