#pragma once

#include <gdal_priv.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/geo/crs.hpp"

namespace terravox::heightmap {

/// How a raster of heights is to be read.
struct Reading {
    std::filesystem::path path;
    std::optional<geo::Crs> crs;          ///< overrides the file's own
    std::optional<geo::Crs> warped_to;    ///< reprojected to this CRS, north up; nullopt: as it is
    std::optional<double> height_unit_m;  ///< overrides the file's own
};

/// Heights of some cells, metres; NaN where there is none. Row by row.
struct Cells {
    int x = 0, y = 0, width = 0, height = 0;  ///< in cells of the grid that they are of
    std::vector<double> metres;
    [[nodiscard]] double at(int cell_x, int cell_y) const noexcept {
        return metres[static_cast<std::size_t>(cell_y - y) * static_cast<std::size_t>(width) +
                      static_cast<std::size_t>(cell_x - x)];
    }
};

/// Why an opened raster has no heights: more bands than one and alpha, colours, complex values.
/// Empty: nothing speaks against heights.
[[nodiscard]] std::string fault_of_heights(GDALDataset& raster);

/// One opened raster of heights. Not thread-safe: one for each thread.
class HeightFile {
public:
    /// @throws Error naming the file when it is missing, not a raster, not georeferenced, or has
    /// blocks too large for memory
    explicit HeightFile(const Reading& reading);

    [[nodiscard]] const std::filesystem::path& path() const noexcept { return m_reading.path; }
    [[nodiscard]] const geo::Crs& crs() const noexcept { return *m_crs; }
    /// North or south up; rows run from west to east.
    [[nodiscard]] bool north_up() const noexcept { return m_geo[2] == 0 && m_geo[4] == 0; }
    [[nodiscard]] std::string copyright() const;
    [[nodiscard]] int overviews() const noexcept { return m_band->GetOverviewCount(); }

    /// The cells as they are, an overview of them, or every stride-th cell of these.
    struct Grid {
        int overview = -1;  ///< of GDAL; -1: none
        int stride = 1;     ///< cells to a cell of this grid
        int width = 0;
        int height = 0;
        /// Place of the first cell's outer corner, and steps to the next; dy < 0: north up.
        double x0 = 0;
        double y0 = 0;
        double dx = 0;
        double dy = 0;
    };
    /// For columns with edges of `side` (units of crs()): the cells, or the coarsest overview with
    /// at least two cells to a side; where there are very many, with a stride.
    [[nodiscard]] Grid grid_for(double side) const noexcept;

    /// @param x, y, width, height cells of the grid, inside it
    /// @throws Error naming the file when it is damaged
    [[nodiscard]] Cells read(const Grid& grid, int x, int y, int width, int height);

    /// Lowest and highest, metres.
    struct Range {
        double low_m = 0;
        double high_m = 0;
        bool exact = true;  ///< false: from a part of its blocks, or from an overview
    };
    /// @param max_cells approximate limit of the cells that are read
    /// @return nullopt: no heights in the cells that were read
    /// @throws Error when all cells that were read are damaged
    [[nodiscard]] std::optional<Range> rough_range(double max_cells);

    /// Outline in units of crs().
    struct Outline {
        double west = 0;
        double south = 0;
        double east = 0;
        double north = 0;
    };
    [[nodiscard]] Outline outline() const noexcept;
    /// Approximate edge of a cell, metres.
    [[nodiscard]] double cell_m() const noexcept;

private:
    [[noreturn]] void fail(const std::string& what) const;
    void open();
    void warp();
    void learn();
    void learn_values();
    [[nodiscard]] double vertical_unit_m() const;  ///< as defined by the CRSs
    [[nodiscard]] double stated_unit_m() const;
    void to_metres(std::vector<double>& values) const noexcept;
    [[nodiscard]] std::optional<Grid> make_grid(double max_cells) const noexcept;
    void extend(std::optional<Range>& range, const Grid& grid, int x, int y, int width, int height);

    Reading m_reading;
    GDALDatasetUniquePtr m_source, m_warped;  // the second reads the first, so it is closed first
    GDALDataset* m_data = nullptr;
    GDALRasterBand* m_band = nullptr;
    std::optional<geo::Crs> m_crs;
    geo::KeyedUnit m_keyed_unit;
    std::array<double, 6> m_geo{};
    double m_scale = 1, m_offset = 0;  // of values, to metres
    std::optional<double> m_nodata;
    bool m_float_nodata = false;
    bool m_signed_bytes = false;
    bool m_masked = false;
};

}  // namespace terravox::heightmap
