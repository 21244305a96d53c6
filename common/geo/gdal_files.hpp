#pragma once

#include <gdal.h>
#include <gdal_priv.h>
#include <filesystem>
#include <string>
#include <utility>

#include "common/util/error.hpp"

namespace terravox::geo {

/// A file of a format of rasters that cannot be read.
class RasterError : public util::Error {
public:
    RasterError(const std::string& message, std::string why)
        : Error(message), reason(std::move(why)) {}
    const std::string reason;  ///< GDAL's, or the gate's
};

/// Opens a raster from any source for reading: a file of one of kRasterFormats that passes the gate
/// (raster_gate.hpp). `path` must name a plain file; GDAL's special names (/vsicurl/...,
/// GTIFF_DIR:...) are not accepted. A TIFF file that was truncated before its last directory, e.g.
/// that of an overview, is refused; as a source of a .vrt it is damage of what it would show.
/// Thread-safe; the returned data set must be used by one thread at a time.
/// @param attempt beginning of the error message: "read the orthophoto"
/// @param overview index, from 0, of the GDAL overview to read instead of the raster; negative: the
/// raster itself
/// @return never null; at least one band
/// @throws RasterError naming the file, and another Error where no format knows it
[[nodiscard]] GDALDatasetUniquePtr open_raster(const std::filesystem::path& path,
                                               const std::string& attempt, int overview = -1);

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
