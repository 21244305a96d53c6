#pragma once

#include <cstddef>
#include <cstdint>

namespace terravox::geo {

/// Limit of GDAL's block cache for all open rasters together, in addition to any memory limit of a
/// world. GDAL's default is a twentieth of the machine's memory. Enough for a 1 km square in pixels
/// of 0.2 m (75 MB): where a PNG of that size does not fit, GDAL decodes it from its first row for
/// nearly every box. Tiled TIFFs need next to nothing.
inline constexpr std::int64_t kGdalCache_bytes = std::int64_t{128} << 20;

/// Initialises GDAL: registers the required drivers, behind a gate (raster_gate.hpp), and sets the
/// cache limit (GDAL_CACHEMAX in the environment takes precedence). Thread-safe; calls after the
/// first do nothing.
/// @throws std::bad_alloc as check_memory_for_gdal()
void start_gdal();

/// Sets another limit than kGdalCache_bytes, for programs that promise to stay within a memory
/// limit. GDAL_CACHEMAX takes precedence over this, too. Thread-safe.
/// @throws as start_gdal()
void limit_gdal_cache(std::int64_t bytes);

/// Must be called before GDAL writes a file, since libgeotiff, which GDAL uses, does not check its
/// small allocations (start_gdal() calls it, too); also tells whether memory is short where PROJ or
/// GDAL do not say why they failed. Thread-safe.
/// @throws std::bad_alloc unless kGdalHeadroom_bytes can be allocated now
void check_memory_for_gdal();
inline constexpr std::size_t kGdalHeadroom_bytes = std::size_t{16} << 20;

}  // namespace terravox::geo
