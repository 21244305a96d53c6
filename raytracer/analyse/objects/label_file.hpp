#pragma once

#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "common/util/atomic_file.hpp"
#include "raytracer/analyse/objects/connected_cells.hpp"
#include "raytracer/analyse/objects/polygon_cells.hpp"
#include "raytracer/core/output/gdal_writing.hpp"

namespace terravox::analyse {

/// The numbers of objects, cell by cell, as a temporary raster of Int32 next to an output: 0 where
/// there is none. The file is removed with the object.
///
/// It may be larger than GDAL's cache, and polygons come in any order: so the file has small
/// blocks, and only those that a polygon meets are read and written for it.
class LabelFile {
public:
    /// Numbers the buildings of a raster.
    /// @param out the file that is made of it
    /// @param columns, rows of the raster that was searched
    /// @throws Error when it cannot be written; "interrupted" when stopped
    LabelFile(const std::filesystem::path& out, ConnectedCells& found, int columns, int rows);
    /// Numbers polygons: their features, from 1. A cell belongs to the first polygon that holds its
    /// middle, else to that of the nearest cell within `near`: walls of voxels are up to a voxel
    /// away from those of a map.
    /// @param near distance in cells, 1 to kMaxNear
    /// @throws as above
    LabelFile(const std::filesystem::path& out, const std::vector<ObjectPolygon>& polygons,
              int columns, int rows, int near, const std::stop_token& stop);
    static constexpr int kMaxNear = 2;

    [[nodiscard]] GDALDatasetH dataset() const noexcept { return m_dataset.get(); }

private:
    LabelFile(const std::filesystem::path& out, int columns, int rows);
    using Numbers = std::vector<std::int32_t>;
    /// @param area within the raster
    void read(const CellRectangle& area, Numbers& numbers) const;
    void write(const CellRectangle& area, Numbers& numbers) const;
    [[nodiscard]] CellRectangle row(int row) const noexcept { return {0, row, m_columns, 1}; }
    /// Gives a polygon's number to those of its cells that have none.
    void number(const overlay::Footprint& part, std::int32_t number,
                const std::stop_token& stop) const;
    /// Gives cells without a number that of the nearest one.
    void widen(int near, const std::stop_token& stop) const;

    const std::string m_attempt;
    const int m_columns;
    const int m_rows;
    util::AtomicFile m_file;  // outlives the dataset in it; never committed
    output::GdalDataset m_dataset;
};

}  // namespace terravox::analyse
