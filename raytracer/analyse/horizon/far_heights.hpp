#pragma once

#include <filesystem>
#include <optional>

#include "common/geo/crs.hpp"
#include "voxelserver/make/worlds/heightmap/height_file.hpp"

namespace terravox::analyse {

/// Heights around a place, from a raster in any CRS, in memory: up to 4096 x 4096 of its cells, or
/// of an overview. Immutable.
class FarHeights {
public:
    /// A rectangle of the map, units of its CRS.
    struct Area {
        double west = 0;
        double south = 0;
        double east = 0;
        double north = 0;
    };

    /// Reads the heights of an area.
    /// @param crs of the map
    /// @param metres_per_unit of the map
    /// @throws Error naming the file: as heightmap::HeightFile, and where it has no cell in the
    /// area
    FarHeights(const std::filesystem::path& file, const geo::Crs& crs, const Area& area,
               double metres_per_unit);

    /// Bilinear between the middles of cells.
    /// @return metres above the sea; nullopt: there are none
    [[nodiscard]] std::optional<double> at(double easting, double northing) const noexcept;
    /// Edge of a cell, metres.
    [[nodiscard]] double cell_m() const noexcept { return m_cell_m; }
    [[nodiscard]] double highest_m() const noexcept { return m_highest_m; }

private:
    heightmap::HeightFile::Grid m_grid;
    heightmap::Cells m_cells;
    double m_cell_m = 0;
    double m_highest_m = 0;
};

}  // namespace terravox::analyse
