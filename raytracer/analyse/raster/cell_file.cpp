#include "raytracer/analyse/raster/cell_file.hpp"

#include <string>

#include "common/util/error.hpp"
#include "common/util/text.hpp"
#include "raytracer/core/output/tile_stream.hpp"

namespace terravox::analyse {
namespace {

constexpr int kTiffTiles = 16;

/// Writes how a band is drawn into its metadata: of bands without a title nothing.
void add_style(GDALRasterBandH to, const BandStyle& style) {
    const auto add = [&](const char* name, const std::string& value) {
        GDALSetMetadataItem(to, name, value.c_str(), nullptr);
    };
    if (style.title.empty())
        return;
    add("terravox_title", std::string(style.title));
    add("terravox_ramp", std::string(name_of_ramp(style.ramp)));
    if (style.low)
        add("terravox_low", util::plain_number_text(*style.low));
    if (style.high)
        add("terravox_high", util::plain_number_text(*style.high));
    if (style.is_clock)
        add("terravox_form", "clock");
    if (!style.words.empty())
        add("terravox_words", std::string(style.words));
}

}  // namespace

CellFile::CellFile(const std::filesystem::path& out, core::AnalysisKind kind, int columns, int rows,
                   int tile_px)
    : m_bands(find_analysis(kind).bands),
      m_columns(columns),
      m_rows(rows),
      m_block_px(output::file_tile_px(tile_px, kTiffTiles)),
      m_attempt("write the raster " + out.string()),
      m_file(std::filesystem::path(out).replace_extension(".cells.tif")) {
    if (m_block_px == 0)
        throw util::UsageError(m_attempt + ": --tile " + std::to_string(tile_px) +
                               "; allowed: multiples of 16");
    const output::GdalWatch watch(m_attempt);
    // Bands apart, so that those which are derived later rewrite none of the others.
    m_dataset = output::create_tiff(
        m_file.temporary_path(),
        {columns, rows, static_cast<int>(m_bands.size()), GDT_Float32, m_block_px, m_block_px},
        {{"INTERLEAVE", "BAND"}, {"ZLEVEL", "1"}, {"PREDICTOR", "3"}}, watch);
    int number = 0;
    for (const RasterBand& band : m_bands) {
        GDALRasterBandH to = GDALGetRasterBand(m_dataset.get(), ++number);
        GDALSetDescription(to, std::string(band.name).c_str());
        watch.check(GDALSetRasterNoDataValue(to, static_cast<double>(core::kNoData)) == CE_None);
        if (!band.unit.empty())
            watch.check(GDALSetRasterUnitType(to, std::string(band.unit).c_str()) == CE_None);
        add_style(to, band.style);
    }
}

void CellFile::add(const tiles::TileResult& result) {
    const tiles::RenderTile& t = result.tile;
    const CellRectangle area{t.x0, t.y0, t.x1 - t.x0, t.y1 - t.y0};
    const auto cells = static_cast<std::size_t>(area.width) * static_cast<std::size_t>(area.height);
    const std::size_t count = count_measured(m_bands);
    if (t.step != 1 || t.refines || t.x1 > m_columns || t.y1 > m_rows ||
        result.bands.size() != cells * count)
        throw util::Error(m_attempt + ": a tile of " + std::to_string(cells) + " cells has " +
                          std::to_string(result.bands.size()) + " values; allowed: " +
                          std::to_string(cells * count) + ", of a single pass");
    std::vector<float> values(cells);
    for (const RasterBand& band : m_bands) {
        if (band.is_derived)
            continue;
        const std::size_t from = find_plane(m_bands, band.name);
        for (std::size_t i = 0; i < cells; ++i)
            values[i] = result.bands[i * count + from];
        write(band.name, area, values);
    }
}

GDALRasterBandH CellFile::find_band(std::string_view name) const {
    const auto found = std::find_if(m_bands.begin(), m_bands.end(),
                                    [&](const RasterBand& band) { return band.name == name; });
    if (found == m_bands.end())
        throw util::Error("find the band " + std::string(name) + ": the analysis has none");
    return GDALGetRasterBand(m_dataset.get(), static_cast<int>(found - m_bands.begin()) + 1);
}

void CellFile::read(std::string_view band, const CellRectangle& area, std::vector<float>& values) {
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
    watch.check(GDALRasterIOEx(find_band(band), GF_Read, x0, y0, x1 - x0, y1 - y0, to, x1 - x0,
                               y1 - y0, GDT_Float32, sizeof(float),
                               static_cast<GSpacing>(width * sizeof(float)), nullptr) == CE_None);
}

void CellFile::write(std::string_view band, const CellRectangle& area, std::vector<float>& values) {
    const output::GdalWatch watch(m_attempt);
    watch.check(GDALRasterIOEx(find_band(band), GF_Write, area.x0, area.y0, area.width, area.height,
                               values.data(), area.width, area.height, GDT_Float32, 0, 0,
                               nullptr) == CE_None);
}

void check_raster_target(const std::filesystem::path& out) {
    const std::string ending = util::lower_extension(out);
    if (ending != ".tif" && ending != ".tiff")
        throw util::UsageError("write the raster " + out.string() + ": the ending '" + ending +
                               "'; allowed: .tif .tiff");
    util::check_writable(out);
}

void write_raster(GDALDatasetH cells, const std::string& attempt, const std::filesystem::path& out,
                  const output::PictureInfo& info, int threads, bool has_floats) {
    const output::GdalWatch watch(attempt);
    output::describe_geotiff(cells, info, watch);
    GDALFlushCache(cells);
    util::AtomicFile target(out);
    output::CogOptions options;
    options.has_floats = has_floats;
    options.block_px = 256;
    options.overview_resampling = "NEAREST";
    options.threads = std::to_string(threads);
    output::write_cog(cells, target.temporary_path(), options, watch);
    target.commit();
}

void write_raster(CellFile& cells, const std::filesystem::path& out,
                  const output::PictureInfo& info, int threads) {
    write_raster(cells.dataset(), cells.attempt(), out, info, threads, true);
}

}  // namespace terravox::analyse
