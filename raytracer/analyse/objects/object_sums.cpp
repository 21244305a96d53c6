#include "raytracer/analyse/objects/object_sums.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "common/util/det_math.hpp"
#include "common/voxel/material.hpp"
#include "raytracer/core/base/analysis_bands.hpp"
#include "raytracer/core/base/material_groups.hpp"

namespace terravox::analyse {
namespace {

constexpr double kRad = det::kPi / 180;
constexpr std::array<const char*, kFacings> kNames = {"N",  "NE", "E",  "SE",  "S",
                                                      "SW", "W",  "NW", "flat"};

const FaceSums& choose_best(const ObjectSums& sums, Facing& which) noexcept {
    std::size_t best = 0;
    for (std::size_t i = 1; i < kFacings; ++i)
        if (sums.faces[i].kwh > sums.faces[best].kwh)
            best = i;
    which = static_cast<Facing>(best);
    return sums.faces[best];
}

}  // namespace

const char* to_name(Facing facing) noexcept {
    return kNames[static_cast<std::size_t>(facing)];
}

Facing find_facing(float slope_deg, float aspect_deg) noexcept {
    if (aspect_deg == core::kNoData || static_cast<double>(slope_deg) < kFlat_deg)
        return Facing::kFlat;
    constexpr double kSector_deg = 45;
    const double sector = std::floor(static_cast<double>(aspect_deg) / kSector_deg + 0.5);
    return static_cast<Facing>(static_cast<int>(sector) % 8);
}

void ObjectSums::add(const EnergyCell& cell, double cell_m2) noexcept {
    ++cells;
    if (cell.kwh_m2 == core::kNoData) {
        ++cells_without_value;
        return;
    }
    const det::SinCos slope = det::sin_cos(static_cast<double>(cell.slope_deg) * kRad);
    const bool is_level = cell.aspect_deg == core::kNoData;
    const det::SinCos azimuth =
        det::sin_cos(is_level ? 0 : static_cast<double>(cell.aspect_deg) * kRad);
    const double surface_m2 = cell_m2 / slope.cos;
    hours_m2 += static_cast<double>(cell.sun_hours) * surface_m2;
    FaceSums& face = faces[static_cast<std::size_t>(find_facing(cell.slope_deg, cell.aspect_deg))];
    face.surface_m2 += surface_m2;
    face.kwh += static_cast<double>(cell.kwh_m2) * surface_m2;
    face.east += azimuth.sin * slope.sin * surface_m2;
    face.up += slope.cos * surface_m2;
    face.south -= azimuth.cos * slope.sin * surface_m2;
}

void ObjectSums::add(const ObjectSums& other) noexcept {
    cells += other.cells;
    cells_without_value += other.cells_without_value;
    hours_m2 += other.hours_m2;
    for (std::size_t i = 0; i < kFacings; ++i) {
        const FaceSums& from = other.faces[i];
        FaceSums& to = faces[i];
        to.surface_m2 += from.surface_m2;
        to.kwh += from.kwh;
        to.east += from.east;
        to.up += from.up;
        to.south += from.south;
    }
}

ObjectFacts collect_facts(const ObjectSums& sums, double cell_m2) noexcept {
    ObjectFacts out;
    out.cells = sums.cells;
    out.cells_without_value = sums.cells_without_value;
    out.area_m2 = static_cast<double>(sums.cells) * cell_m2;
    if (!out.has_values())
        return out;
    for (const FaceSums& face : sums.faces) {
        out.surface_m2 += face.surface_m2;
        out.kwh += face.kwh;
    }
    out.sun_hours = sums.hours_m2 / out.surface_m2;
    const FaceSums& best = choose_best(sums, out.best);
    out.best_surface_m2 = best.surface_m2;
    out.best_kwh = best.kwh;
    const double level = std::sqrt(best.east * best.east + best.south * best.south);
    out.best_slope_deg = det::atan2(level, best.up) / kRad;
    const double azimuth_deg = det::atan2(best.east, 0 - best.south) / kRad;
    out.best_azimuth_deg = azimuth_deg < 0 ? azimuth_deg + 360 : azimuth_deg;
    return out;
}

EnergyRows::EnergyRows(CellFile& cells, const CellRectangle& area)
    : m_cells(cells), m_area(area), m_strip{area.x0, area.y0, area.width, 0}, m_row(area.y0 - 1) {}

bool EnergyRows::next() {
    ++m_row;
    const int end = m_area.y0 + m_area.height;
    if (m_row >= end)
        return false;
    if (m_row < m_strip.y0 + m_strip.height)
        return true;
    m_strip.y0 = m_row;
    m_strip.height = std::clamp(kStripCells / std::max(m_area.width, 1), 1, end - m_row);
    m_cells.read("kwh_m2", m_strip, m_kwh_m2);
    m_cells.read("sun_hours", m_strip, m_sun_hours);
    m_cells.read("slope", m_strip, m_slope_deg);
    m_cells.read("aspect", m_strip, m_aspect_deg);
    m_cells.read("material", m_strip, m_material);
    return true;
}

std::size_t EnergyRows::index(int column) const noexcept {
    return static_cast<std::size_t>(m_row - m_strip.y0) * static_cast<std::size_t>(m_area.width) +
           static_cast<std::size_t>(column);
}

EnergyCell EnergyRows::at(int column) const noexcept {
    const std::size_t i = index(column);
    return {m_kwh_m2[i], m_sun_hours[i], m_slope_deg[i], m_aspect_deg[i]};
}

bool EnergyRows::is_building(int column) const noexcept {
    const auto material = static_cast<int>(m_material[index(column)]);
    return core::is_of_building(static_cast<voxel::Material>(material));
}

}  // namespace terravox::analyse
