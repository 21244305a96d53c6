#pragma once

namespace terravox::geo {

/// Names of GDAL's drivers that open rasters here, with a null at the end: formats that are one
/// file with known side files, and need no network, no SQL and no code.
extern const char* const kRasterDrivers[];

/// The same formats as a person calls them, for messages and help.
inline constexpr const char* kRasterFormats =
    "GeoTIFF, JPEG, PNG, JPEG 2000, .vrt mosaics, Esri ASCII grid, .bil and .flt (EHdr), ENVI, "
    "SRTM .hgt, USGS DEM, DTED, XYZ";

/// Registers the drivers, and puts a gate before each of them that all rasters pass, whoever has
/// GDAL open them: our readers, or GDAL itself for a source of a .vrt, an overview or a mask.
/// Refused, with a reason in GDAL's last error:
/// - a virtual raster that is not named .vrt, or does not pass check_virtual_raster();
/// - a side file (side_files.hpp) that is no file, or a link to a place that is neither beside nor
/// below the raster;
/// - a .aux.xml whose coordinate reference system names files (crs_text.hpp);
/// - metadata that send GDAL to other files: OVERVIEW_FILE, GEOLOCATION.
/// Not thread-safe: call it once.
void register_raster_drivers();

}  // namespace terravox::geo
