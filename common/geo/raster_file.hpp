#pragma once

#include <gdal_priv.h>

#include <filesystem>
#include <string>

namespace terravox::geo {

/// Opens a raster for reading, whoever made it: a file of one of kRasterFormats that passes the
/// gate (raster_gate.hpp). The name is that of a file and nothing else: none of GDAL's
/// (/vsicurl/..., GTIFF_DIR:...). A TIFF file that was cut short before its last directory, as of
/// an overview, is refused; of sources of a .vrt that is not seen. Thread-safe; what it returns is
/// for one thread at a time.
/// @param attempt beginning of the message when it fails: "read the orthophoto"
/// @param overview of GDAL's, from 0, to be read instead of the raster; negative: the raster itself
/// @return never null, with one band at least
/// @throws Error naming the file
[[nodiscard]] GDALDatasetUniquePtr open_raster(const std::filesystem::path& path,
                                               const std::string& attempt, int overview = -1);

}  // namespace terravox::geo
