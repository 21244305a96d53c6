#include "common/geo/gdal.hpp"

#include <cpl_conv.h>
#include <gdal.h>

#include <mutex>

#include "common/geo/raster_gate.hpp"

namespace terravox::geo {
namespace {

void limit(std::int64_t bytes) {
    if (CPLGetConfigOption("GDAL_CACHEMAX", nullptr) == nullptr)
        GDALSetCacheMax64(bytes);
}

}  // namespace

void start_gdal() {
    static std::once_flag once;
    std::call_once(once, [] {
        register_raster_drivers();
        limit(kGdalCache_bytes);
    });
}

void limit_gdal_cache(std::int64_t bytes) {
    start_gdal();
    limit(bytes);
}

}  // namespace terravox::geo
