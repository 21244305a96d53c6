#include "raytracer/analyse/raster/cell_file.hpp"

#include <algorithm>

#include "common/util/error.hpp"
#include "raytracer/core/output/stream_formats.hpp"

namespace terravox::analyse {
namespace {

constexpr int kTiffTiles = 16;

}  // namespace

CellFile::CellFile(const std::filesystem::path& out, core::AnalysisKind kind, int columns, int rows,
                   int tile_px)
    : m_kind(kind),
      m_columns(columns),
      m_rows(rows),
      m_block_px(output::file_tile_px(tile_px, kTiffTiles)),
      m_attempt("write the raster " + out.string()),
      m_file(std::filesystem::path(out).replace_extension(".cells.tif")) {
    if (m_block_px == 0)
        throw util::UsageError(m_attempt + ": --tile " + std::to_string(tile_px) +
                               "; allowed: multiples of 16");
    const output::GdalWatch watch(m_attempt);
    const auto bands = bands_of(kind);
    // Bands apart, so that those which are derived later rewrite none of the others.
    output::GdalOptions options = {{"TILED", "YES"},
                                   {"BLOCKXSIZE", std::to_string(m_block_px)},
                                   {"BLOCKYSIZE", std::to_string(m_block_px)},
                                   {"INTERLEAVE", "BAND"},
                                   {"COMPRESS", "DEFLATE"},
                                   {"ZLEVEL", "1"},
                                   {"PREDICTOR", "3"},
                                   {"BIGTIFF", "YES"}};
    m_dataset.reset(GDALCreate(GDALGetDriverByName("GTiff"),
                               m_file.temporary_path().string().c_str(), columns, rows,
                               static_cast<int>(bands.size()), GDT_Float32, options.list()));
    watch.check(m_dataset != nullptr);
    int number = 0;
    for (const RasterBand& band : bands) {
        GDALRasterBandH to = GDALGetRasterBand(m_dataset.get(), ++number);
        GDALSetDescription(to, std::string(band.name).c_str());
        watch.check(GDALSetRasterNoDataValue(to, static_cast<double>(core::kNoData)) == CE_None);
        if (!band.unit.empty())
            watch.check(GDALSetRasterUnitType(to, std::string(band.unit).c_str()) == CE_None);
    }
}

void CellFile::add(const tiles::TileResult& result) {
    const tiles::RenderTile& t = result.tile;
    const CellRectangle area{t.x0, t.y0, t.x1 - t.x0, t.y1 - t.y0};
    const auto cells = static_cast<std::size_t>(area.width) * static_cast<std::size_t>(area.height);
    const std::size_t count = core::band_count(m_kind);
    if (t.step != 1 || t.refines || t.x1 > m_columns || t.y1 > m_rows ||
        result.bands.size() != cells * count)
        throw util::Error(m_attempt + ": a tile of " + std::to_string(cells) + " cells has " +
                          std::to_string(result.bands.size()) + " values; allowed: " +
                          std::to_string(cells * count) + ", of a single pass");
    std::vector<float> values(cells);
    int number = 0;
    for (const RasterBand& band : bands_of(m_kind)) {
        ++number;
        if (band.measured == kDerived)
            continue;
        const auto from = static_cast<std::size_t>(band.measured);
        for (std::size_t i = 0; i < cells; ++i)
            values[i] = result.bands[i * count + from];
        write(number, area, values);
    }
}

void CellFile::read(int band, const CellRectangle& area, std::vector<float>& values) {
    const auto width = static_cast<std::size_t>(area.width);
    values.assign(width * static_cast<std::size_t>(area.height), core::kNoData);
    const int x0 = std::max(area.x0, 0);
    const int y0 = std::max(area.y0, 0);
    const int x1 = std::min(area.x0 + area.width, m_columns);
    const int y1 = std::min(area.y0 + area.height, m_rows);
    if (x0 >= x1 || y0 >= y1)
        return;
    const output::GdalWatch watch(m_attempt);
    float* to = values.data() + static_cast<std::size_t>(y0 - area.y0) * width +
                static_cast<std::size_t>(x0 - area.x0);
    watch.check(GDALRasterIOEx(GDALGetRasterBand(m_dataset.get(), band), GF_Read, x0, y0, x1 - x0,
                               y1 - y0, to, x1 - x0, y1 - y0, GDT_Float32, sizeof(float),
                               static_cast<GSpacing>(width * sizeof(float)), nullptr) == CE_None);
}

void CellFile::write(int band, const CellRectangle& area, std::vector<float>& values) {
    const output::GdalWatch watch(m_attempt);
    watch.check(GDALRasterIOEx(GDALGetRasterBand(m_dataset.get(), band), GF_Write, area.x0, area.y0,
                               area.width, area.height, values.data(), area.width, area.height,
                               GDT_Float32, 0, 0, nullptr) == CE_None);
}

}  // namespace terravox::analyse
