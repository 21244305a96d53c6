#pragma once

#include <cstddef>
#include <cstdint>

namespace terravox::geo {

/// What GDAL may keep of the blocks of images that it has read, all files together, beside any
/// memory limit of a world. Left to itself it takes a twentieth of the machine's memory. Enough for
/// a 1 km square in pixels of 0.2 m (75 MB): where a PNG of that size does not fit, GDAL decodes it
/// from its first row for nearly every box. Tiled TIFFs need next to nothing.
inline constexpr std::int64_t kGdalCache_bytes = std::int64_t{128} << 20;

/// Makes GDAL ready: the drivers that are needed, behind a gate (raster_gate.hpp), and the limit of
/// its cache (GDAL_CACHEMAX in the environment goes before it). Thread-safe; all calls but the
/// first do nothing.
void start_gdal();

/// Another limit than kGdalCache_bytes, for programs that promise to stay within some memory.
/// GDAL_CACHEMAX goes before this, too. Thread-safe.
void limit_gdal_cache(std::int64_t bytes);

/// To be called before GDAL writes a file: libgeotiff, below it, does not check its small
/// allocations. Thread-safe.
/// @throws std::bad_alloc unless kGdalHeadroom_bytes can be allocated now
void check_memory_for_gdal();
inline constexpr std::size_t kGdalHeadroom_bytes = std::size_t{16} << 20;

}  // namespace terravox::geo
