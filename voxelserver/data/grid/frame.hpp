#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <string>

#include "common/geo/crs.hpp"

namespace terravox::grid {

/// Converts coordinates of the world's CRS to voxel coordinates: x = E / voxel, z = -N / voxel, y =
/// H / voxel, absolute, so that any two requests agree (design: Space). Immutable.
class Frame {
public:
    /// @param voxel_m edge of a voxel, metres, (0, 1000]
    /// @param centre_e, centre_n a point in the data: EPSG:3857 is corrected for the scale at its
    /// latitude
    /// @throws UsageError for a geographic CRS (degrees are not lengths) or an invalid voxel size
    Frame(geo::Crs crs, double voxel_m, double centre_e, double centre_n);

    [[nodiscard]] const geo::Crs& crs() const noexcept { return m_crs; }
    [[nodiscard]] double voxel_m() const noexcept { return m_voxel_m; }
    [[nodiscard]] double units_per_voxel() const noexcept { return m_units_per_voxel; }
    /// Continuous voxel coordinates; floor() is the voxel. H in metres.
    [[nodiscard]] double x(double easting) const noexcept { return easting / m_units_per_voxel; }
    [[nodiscard]] double z(double northing) const noexcept { return -northing / m_units_per_voxel; }
    [[nodiscard]] double y(double height_m) const noexcept { return height_m / m_voxel_m; }
    [[nodiscard]] double easting(double x) const noexcept { return x * m_units_per_voxel; }
    [[nodiscard]] double northing(double z) const noexcept { return -z * m_units_per_voxel; }

private:
    geo::Crs m_crs;
    double m_voxel_m;
    double m_units_per_voxel;
};

/// The CRS in which voxels are made for data in `file_crs`: the same, or, logged, the UTM zone of
/// the centre for degrees.
/// @param centre_x longitude in degrees, [-180, 360]: of grids from 0 to 360, too
/// @throws UsageError for a centre that is not in degrees
[[nodiscard]] geo::Crs voxel_crs_for(const geo::Crs& file_crs, double centre_x, double centre_y);

/// What is wrong with the place of a raster whose CRS has degrees, as the end of a message; empty:
/// nothing, or it has no degrees.
/// @param geo GDAL's geotransform
[[nodiscard]] std::string fault_of_degrees(const geo::Crs& crs, const std::array<double, 6>& geo,
                                           int width, int height);

}  // namespace terravox::grid
