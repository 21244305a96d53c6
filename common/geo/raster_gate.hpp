#pragma once

namespace terravox::geo {

/// Names of the GDAL drivers that are allowed to open rasters, null-terminated: formats that
/// consist of one file with known side files, and need no network, no SQL and no code.
extern const char* const kRasterDrivers[];

/// The same formats under their common names, for messages and help.
inline constexpr const char* kRasterFormats =
    "GeoTIFF, JPEG, PNG, JPEG 2000, .vrt mosaics, Esri ASCII grid, .bil and .flt (EHdr), ENVI, "
    "SRTM .hgt, USGS DEM, DTED, XYZ";

/// Registers the drivers, each behind a gate that every raster passes, whether it is opened by our
/// readers or by GDAL itself as a source of a .vrt, an overview or a mask. Refused, with a reason
/// in GDAL's last error:
/// - a virtual raster that is not named .vrt, or does not pass check_virtual_raster();
/// - a side file (side_files.hpp) that is not a plain file, or a link to a place that is neither
/// next to nor below the raster;
/// - a .aux.xml whose coordinate reference system names files (crs_text.hpp);
/// - metadata that refer GDAL to other files: OVERVIEW_FILE, GEOLOCATION.
///
/// Not thread-safe: call it once.
void register_raster_drivers();

}  // namespace terravox::geo
