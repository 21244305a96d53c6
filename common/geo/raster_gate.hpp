#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace terravox::geo {

/// The names of the files next to a raster that may georeference it, or hold its overviews and
/// masks: world files, .prj, .tab, .hdr, .aux.xml, .ovr, .msk, in lower and in upper case. They
/// need not exist. Computed from the name alone, without accessing the file system.
[[nodiscard]] std::vector<std::filesystem::path> side_files(const std::filesystem::path& raster);

/// Checks a virtual raster (.vrt) before GDAL opens it. A .vrt can act like a program: it names
/// files and addresses to read, can read any file as raw values, and may call code. Here only
/// mosaics are accepted: bands made of sources (<SimpleSource>, <ComplexSource> and related
/// elements, masks and overviews), where each source is a file next to or below the .vrt, after
/// resolving all links. Refused: raw, derived, warped and pansharpened bands, open options, names
/// relative to the working directory, .vrt nested deeper than 4, more than 64 MiB of text in all.
/// Thread-safe.
/// @throws Error with the reason, without the name of the file
void check_virtual_raster(const std::filesystem::path& vrt);

/// Whether a file lies in the folder or below it, after resolving all links; a file that does not
/// exist is judged by where it would lie.
[[nodiscard]] bool lies_in(const std::filesystem::path& file, const std::filesystem::path& folder);

/// What is wrong with the values of an Esri ASCII grid: one that is no number, which GDAL reads as
/// 0, or an end before the last one. GDAL finds rows by reading those before
/// them; behind the end of the file each row doubles the number of attempts, which takes for ever.
/// Reads the file once, and stops where it has enough.
/// @param values of all rows, by the header
/// @return nullopt: nothing
/// @throws Error when the file cannot be read
[[nodiscard]] std::optional<std::string> find_fault_of_grid(const std::filesystem::path& file,
                                                            std::uint64_t values);

/// Checks whether a TIFF file that GDAL has written and closed is complete. GDAL (3.6, at least)
/// does not report when its last write fails, as it does on a full disk: the file then ends before
/// pixels that its directories refer to. Reads only the directories, of the image and of its
/// overviews. Thread-safe; start_gdal() or an equivalent must have been called.
/// @return what is missing, in a few words; nullopt when the file is complete
[[nodiscard]] std::optional<std::string> find_missing_part_of_tiff(
    const std::filesystem::path& file);

/// Checks whether all directories of a TIFF file from any source lie within it, with their lists of
/// block offsets. GDAL silently skips those that do not: a truncated file loses its overviews
/// without an error. Reads only the directories. Thread-safe.
/// @return which directory is lost, in a few words; nullopt when none is, or the file is not a TIFF
[[nodiscard]] std::optional<std::string> find_lost_directory_of_tiff(
    const std::filesystem::path& file);

/// The GeoTIFF keys (tag 34735) of the first directory of a TIFF file from any source. GDAL hands
/// out only what it makes of them. Thread-safe.
/// @return empty where there are none, or the file is not a TIFF
[[nodiscard]] std::vector<std::uint16_t> find_geokeys_of_tiff(const std::filesystem::path& file);

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
/// - a side file that is not a plain file, or a link to a place that is neither
/// next to nor below the raster;
/// - a .aux.xml whose coordinate reference system names files (crs.hpp);
/// - metadata that refer GDAL to other files: OVERVIEW_FILE, GEOLOCATION.
///
/// Not thread-safe: call it once.
void register_raster_drivers();

}  // namespace terravox::geo
