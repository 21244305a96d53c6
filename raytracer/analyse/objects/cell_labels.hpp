#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "common/util/atomic_file.hpp"
#include "raytracer/analyse/objects/object_sums.hpp"
#include "raytracer/analyse/objects/polygon_cells.hpp"
#include "raytracer/core/output/gdal_writing.hpp"

namespace terravox::analyse {

/// Gives the cells of a raster that belong together a common label, row by row from the north. Two
/// cells belong together when they have a side in common, or others between them do.
///
/// A row is labelled before those below are known, so that two labels may turn out to be of one
/// thing: they are joined. The same rows always get the same labels.
/// Ref: Rosenfeld & Pfaltz, "Sequential operations in digital picture processing", 1966.
class RowLabels {
public:
    static constexpr std::int32_t kNone = 0;
    /// Labels of a raster, which are more than things.
    static constexpr std::int32_t kMaxLabels = 16'000'000;

    explicit RowLabels(int columns);

    /// Labels the next row.
    /// @param belongs calls for a column: whether the cell belongs to a thing
    /// @param join calls with two labels, of which the second is no longer used
    /// @throws Error for more than kMaxLabels
    template <class Belongs, class Join>
    void next(const Belongs& belongs, const Join& join);
    /// Those of the last row; kNone: cells that belong to nothing.
    [[nodiscard]] std::span<const std::int32_t> row() const noexcept { return m_row; }
    /// The label that stands for all that it was joined with: the first of them.
    [[nodiscard]] std::int32_t joined(std::int32_t label) noexcept;
    /// Labels run from 1 to here.
    [[nodiscard]] std::int32_t last() const noexcept {
        return static_cast<std::int32_t>(m_parents.size()) - 1;
    }

private:
    [[nodiscard]] std::int32_t new_label();

    std::vector<std::int32_t> m_parents;  ///< by label
    std::vector<std::int32_t> m_row;
};

template <class Belongs, class Join>
void RowLabels::next(const Belongs& belongs, const Join& join) {
    std::int32_t left = kNone;
    for (std::size_t x = 0; x < m_row.size(); ++x) {
        if (!belongs(static_cast<int>(x))) {
            left = m_row[x] = kNone;
            continue;
        }
        const std::int32_t above = m_row[x] == kNone ? kNone : joined(m_row[x]);
        if (left == kNone)
            left = above == kNone ? new_label() : above;
        if (above != kNone && above != left) {
            const std::int32_t kept = above < left ? above : left;
            const std::int32_t dropped = above < left ? left : above;
            m_parents[static_cast<std::size_t>(dropped)] = kept;
            join(kept, dropped);
            left = kept;
        }
        m_row[x] = left;
    }
}

/// The buildings of a raster: connected cells of roofs, walls and solar panels. They are numbered
/// from 1 in the order of their first cells, row by row from the north-west.
class ConnectedCells {
public:
    /// What a GeoPackage is made of, in memory.
    static constexpr std::size_t kMaxObjects = 1'000'000;

    /// Reads all cells.
    /// @param cell_m2 of a cell
    /// @throws Error as CellFile; for more than kMaxObjects; "interrupted" when stopped
    ConnectedCells(CellFile& cells, double cell_m2, const std::stop_token& stop);

    [[nodiscard]] const std::vector<ObjectFacts>& facts() const noexcept { return m_facts; }

    /// Reads all cells again, and calls take(row, numbers of its cells; 0: none) for each row.
    /// @throws Error as the constructor
    template <class Take>
    void each_row(const Take& take);

private:
    /// A building that the next row may go on with.
    struct Growing {
        ObjectSums sums;
        int last_row = 0;
    };
    void finish_above(int row, double cell_m2);
    void number_all();

    CellFile& m_cells;
    const std::stop_token m_stop;
    std::map<std::int32_t, Growing> m_growing;  ///< by label
    std::map<std::int32_t, ObjectFacts> m_done;
    std::vector<std::int32_t> m_numbers;  ///< by label
    std::vector<ObjectFacts> m_facts;
};

/// @throws Error "interrupted" when stopped
void check_stop(const std::stop_token& stop);

template <class Take>
void ConnectedCells::each_row(const Take& take) {
    RowLabels labels(m_cells.columns());
    EnergyRows rows(m_cells, {0, 0, m_cells.columns(), m_cells.rows()});
    std::vector<std::int32_t> numbers(static_cast<std::size_t>(m_cells.columns()));
    while (rows.next()) {
        check_stop(m_stop);
        labels.next([&](int x) { return rows.is_building(x); }, [](std::int32_t, std::int32_t) {});
        for (std::size_t x = 0; x < numbers.size(); ++x)
            numbers[x] = m_numbers[static_cast<std::size_t>(labels.row()[x])];
        take(rows.row(), numbers);
    }
}

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
