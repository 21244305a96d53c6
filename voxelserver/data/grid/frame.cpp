#include "voxelserver/data/grid/frame.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "common/util/error.hpp"
#include "common/util/log.hpp"

namespace terravox::grid {

Frame::Frame(geo::Crs crs, double voxel_m, double centre_e, double centre_n)
    : m_crs(std::move(crs)), m_voxel_m(voxel_m) {
    if (!(voxel_m > 0 && voxel_m <= 1000))
        throw util::UsageError("set the voxel size: {:f} m; allowed: above 0, up to 1000", voxel_m);
    if (m_crs.geographic())
        throw util::UsageError(
            "make voxels in {}: its units are degrees; give a projected system with --crs",
            m_crs.name());
    double metres_per_unit = m_crs.metres_per_unit();
    // Web Mercator's "metres" are longer than metres by 1 / cos(latitude).
    if (m_crs.pseudo_mercator())
        metres_per_unit *=
            std::cos(geo::to_lat_lon(m_crs, centre_e, centre_n).lat_deg * std::numbers::pi / 180);
    m_units_per_voxel = voxel_m / metres_per_unit;
}

geo::Crs voxel_crs_for(const geo::Crs& file_crs, double centre_x, double centre_y) {
    if (!file_crs.geographic())
        return file_crs;
    if (!(centre_x >= -180 && centre_x <= 360 && std::abs(centre_y) <= 90))
        throw util::UsageError(
            "place the data: {} has degrees, but the middle of the data is {}; allowed: --crs with "
            "the system in metres that the data are in",
            file_crs.name(), fmt::format("{:.1f}, {:.1f}", centre_x, centre_y));
    const double lon_deg = std::remainder(centre_x, 360);  // of longitudes from 0 to 360, too
    const int zone = std::clamp(static_cast<int>(std::floor((lon_deg + 180) / 6)) + 1, 1, 60);
    const std::string name = "EPSG:" + std::to_string((centre_y < 0 ? 32700 : 32600) + zone);
    util::log_info("coordinates in degrees ({}): drawn in {}", file_crs.name(), name);
    return geo::Crs::from_text(name);
}

std::string fault_of_degrees(const geo::Crs& crs, const std::array<double, 6>& geo, int width,
                             int height) {
    if (!crs.geographic())
        return {};
    std::array<double, 4> lon_deg{};
    std::array<double, 4> lat_deg{};
    for (std::size_t i = 0; i < 4; ++i) {
        const double u = i % 2 == 0 ? 0 : width;
        const double v = i / 2 == 0 ? 0 : height;
        lon_deg[i] = geo[0] + u * geo[1] + v * geo[2];
        lat_deg[i] = geo[3] + u * geo[4] + v * geo[5];
    }
    const auto [west, east] = std::minmax_element(lon_deg.begin(), lon_deg.end());
    const auto [south, north] = std::minmax_element(lat_deg.begin(), lat_deg.end());
    // Cells whose middles lie on the last meridian and on a pole reach beyond them.
    const double cell = std::max(std::hypot(geo[1], geo[4]), std::hypot(geo[2], geo[5]));
    if (*west >= -180 - cell && *east <= 360 + cell && *east - *west <= 360 + cell &&
        *south >= -90 - cell && *north <= 90 + cell)
        return {};
    return fmt::format(
        "in {}, which has degrees, its longitudes are {:g} to {:g} and its latitudes {:g} to {:g}; "
        "allowed: -180 to 360, one turn, and -90 to 90",
        crs.name(), *west, *east, *south, *north);
}

}  // namespace terravox::grid
