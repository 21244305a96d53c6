#include "raytracer/analyse/objects/energy_rows.hpp"

#include <algorithm>
#include <string_view>

#include "common/voxel/material.hpp"
#include "raytracer/core/base/building_materials.hpp"

namespace terravox::analyse {

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
    const auto read = [&](std::string_view band, std::vector<float>& to) {
        m_cells.read(band_number(core::AnalysisKind::kEnergy, band), m_strip, to);
    };
    read("kwh_m2", m_kwh_m2);
    read("sun_hours", m_sun_hours);
    read("slope", m_slope_deg);
    read("aspect", m_aspect_deg);
    read("material", m_material);
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
