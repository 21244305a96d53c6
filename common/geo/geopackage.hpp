#pragma once

#include <gdal.h>

namespace terravox::geo {

/// GDAL's driver for GeoPackages, to create them with. It is not among the registered drivers, so
/// that GDAL opens no file with it, whatever the file is (raster_gate.hpp). Thread-safe after a
/// first call, which must be made before other threads use GDAL.
/// @throws Error where GDAL was built without it
[[nodiscard]] GDALDriverH geopackage_driver();

}  // namespace terravox::geo
