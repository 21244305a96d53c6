#pragma once

#include <algorithm>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "common/util/atomic_file.hpp"
#include "raytracer/analyse/evaluators/analysis.hpp"
#include "raytracer/core/base/analysis_bands.hpp"
#include "raytracer/core/output/gdal_writing.hpp"
#include "raytracer/core/output/picture.hpp"

namespace terravox::analyse {

/// About so many cells of a band are read together where a raster is read row by row.
inline constexpr int kStripCells = 1 << 20;

/// A rectangle of cells, [x0, x0 + width) x [y0, y0 + height) of the raster.
struct CellRectangle {
    int x0 = 0;
    int y0 = 0;
    int width = 0;
    int height = 0;
};

/// The bands of a raster in a temporary file next to the output, so that a raster may be larger
/// than memory: measured ones are written as tiles arrive, derived ones block by block afterwards.
/// The file is removed with the object. Not thread-safe.
class CellFile final : public output::TileSink {
public:
    /// @param out the raster that is made of it
    /// @param tile_px edge of the tiles, a multiple of 16
    /// @throws Error when it cannot be written
    CellFile(const std::filesystem::path& out, core::AnalysisKind kind, int columns, int rows,
             int tile_px);

    void add(const tiles::TileResult& result) override;
    /// It is only a file, so a tile may be written again.
    [[nodiscard]] bool replaces() const noexcept override { return true; }

    /// Values of a band, row by row.
    /// @param area may reach beyond the raster, where all is core::kNoData
    /// @throws Error
    void read(std::string_view band, const CellRectangle& area, std::vector<float>& values);
    /// @param area within the raster
    void write(std::string_view band, const CellRectangle& area, std::vector<float>& values);
    /// @throws Error for a name that none of bands() has
    [[nodiscard]] GDALRasterBandH find_band(std::string_view name) const;
    /// In the order of the file.
    [[nodiscard]] std::span<const RasterBand> bands() const noexcept { return m_bands; }

    /// Visits all cells as rectangles whose sides are `edge` or shorter, row by row.
    template <class Visit>
    void each_block(int edge, const Visit& visit) const {
        for (int y = 0; y < m_rows; y += edge)
            for (int x = 0; x < m_columns; x += edge)
                visit(
                    CellRectangle{x, y, std::min(edge, m_columns - x), std::min(edge, m_rows - y)});
    }
    /// Edge of the file's blocks.
    [[nodiscard]] int block_px() const noexcept { return m_block_px; }
    [[nodiscard]] int columns() const noexcept { return m_columns; }
    [[nodiscard]] int rows() const noexcept { return m_rows; }
    /// For the copy that becomes the output; everything that was written is in it.
    [[nodiscard]] GDALDatasetH dataset() const noexcept { return m_dataset.get(); }
    [[nodiscard]] const std::string& attempt() const noexcept { return m_attempt; }

private:
    const std::span<const RasterBand> m_bands;
    const int m_columns;
    const int m_rows;
    const int m_block_px;
    const std::string m_attempt;
    util::AtomicFile m_file;  // outlives the dataset in it; never committed
    output::GdalDataset m_dataset;
};

/// @throws UsageError unless the file's name is that of a TIFF; Error when it cannot be written
void check_raster_target(const std::filesystem::path& out);

/// Writes a raster as a Cloud Optimized GeoTIFF: tiles, overviews (of single cells, since means of
/// classes mean nothing), nodata, and for each band its name and unit. Completely or not at all.
/// @param info georeference and metadata
/// @param threads for compression
/// @throws Error
void write_raster(CellFile& cells, const std::filesystem::path& out,
                  const output::PictureInfo& info, int threads);
/// The same of a dataset. @param attempt for messages
void write_raster(GDALDatasetH cells, const std::string& attempt, const std::filesystem::path& out,
                  const output::PictureInfo& info, int threads, bool has_floats);

}  // namespace terravox::analyse
