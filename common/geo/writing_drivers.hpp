#pragma once

#include <gdal.h>

namespace terravox::geo {

// GDAL's drivers of formats that are written alone. They are not among the registered drivers, so
// that GDAL opens no file with them, whatever the file is (raster_gate.hpp). Thread-safe after a
// first call, which must be made before other threads use GDAL.

/// To create GeoPackages with.
/// @throws Error where GDAL was built without it
[[nodiscard]] GDALDriverH geopackage_driver();

/// To copy rasters to netCDF with.
/// @throws Error where GDAL was built without it
[[nodiscard]] GDALDriverH netcdf_driver();

/// To copy pictures to WebP with.
/// @throws Error where GDAL was built without it
[[nodiscard]] GDALDriverH webp_driver();

}  // namespace terravox::geo
