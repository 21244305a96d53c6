#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "raytracer/analyse/raster/cell_file.hpp"

namespace terravox::analyse {

/// What an object needs to know of a cell of a raster of AnalysisKind::kEnergy.
struct EnergyCell {
    float kwh_m2 = 0;  ///< core::kNoData: the cell has no value
    float sun_hours = 0;
    float slope_deg = 0;
    float aspect_deg = 0;  ///< core::kNoData: level
};

/// Where a surface falls to: one of eight directions, or nowhere.
enum class Facing : std::uint8_t {
    kNorth,
    kNorthEast,
    kEast,
    kSouthEast,
    kSouth,
    kSouthWest,
    kWest,
    kNorthWest,
    kFlat,
};
inline constexpr std::size_t kFacings = 9;
/// Slopes below are flat: they are as much that of steps of voxels as that of a roof.
inline constexpr double kFlat_deg = 5;

/// @return "N", "NE", ..., "flat"
[[nodiscard]] const char* to_name(Facing facing) noexcept;
/// @param aspect_deg degrees clockwise from north; core::kNoData: level
[[nodiscard]] Facing find_facing(float slope_deg, float aspect_deg) noexcept;

/// The cells of an object that face one way.
struct FaceSums {
    double surface_m2 = 0;  ///< as it lies, not as on a map
    double kwh = 0;
    double east = 0, up = 0, south = 0;  ///< sum of the normals of its square metres
};

/// The cells of an object, added up.
struct ObjectSums {
    std::uint64_t cells = 0;
    std::uint64_t cells_without_value = 0;
    double hours_m2 = 0;  ///< hours of sun of each square metre
    std::array<FaceSums, kFacings> faces;

    /// @param cell_m2 its area on the map
    void add(const EnergyCell& cell, double cell_m2) noexcept;
    void add(const ObjectSums& other) noexcept;
};

/// What is known of an object. Where no cell has a value, only counts and the area are.
struct ObjectFacts {
    std::uint64_t cells = 0;
    std::uint64_t cells_without_value = 0;
    double area_m2 = 0;     ///< on the map, of all cells
    double surface_m2 = 0;  ///< as it lies, of cells with a value
    double kwh = 0;         ///< on all of the surface
    double sun_hours = 0;   ///< mean of the surface
    /// The face with the most energy, and means of its surface.
    Facing best = Facing::kFlat;
    double best_azimuth_deg = 0;  ///< [0, 360); of a flat one nothing
    double best_slope_deg = 0;
    double best_surface_m2 = 0;
    double best_kwh = 0;

    [[nodiscard]] bool has_values() const noexcept { return cells > cells_without_value; }
    /// Mean energy of a square metre of the surface.
    [[nodiscard]] double kwh_m2() const noexcept { return kwh / surface_m2; }
};

[[nodiscard]] ObjectFacts collect_facts(const ObjectSums& sums, double cell_m2) noexcept;

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
