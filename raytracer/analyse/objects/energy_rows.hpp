#pragma once

#include <vector>

#include "raytracer/analyse/objects/object_sums.hpp"
#include "raytracer/analyse/raster/cell_file.hpp"

namespace terravox::analyse {

/// The cells of a rectangle of a raster of AnalysisKind::kEnergy, row after row, of which some are
/// in memory at a time. Not thread-safe.
class EnergyRows {
public:
    /// @param area may reach beyond the raster, where no cell has a value
    /// @param cells must outlive it
    EnergyRows(CellFile& cells, const CellRectangle& area);

    /// Goes on to the next row; to be called before the first one, too.
    /// @return false after the last one
    /// @throws Error as CellFile
    bool next();
    /// @return in cells of the raster
    [[nodiscard]] int row() const noexcept { return m_row; }
    /// A cell of the row.
    /// @param column of the rectangle, from 0
    [[nodiscard]] EnergyCell at(int column) const noexcept;
    /// Whether the cell is of a roof, a wall or a solar panel.
    [[nodiscard]] bool is_building(int column) const noexcept;

private:
    [[nodiscard]] std::size_t index(int column) const noexcept;

    CellFile& m_cells;
    CellRectangle m_area;
    CellRectangle m_strip;
    int m_row;
    std::vector<float> m_kwh_m2;
    std::vector<float> m_sun_hours;
    std::vector<float> m_slope_deg;
    std::vector<float> m_aspect_deg;
    std::vector<float> m_material;
};

}  // namespace terravox::analyse
