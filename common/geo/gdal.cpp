#include "common/geo/gdal.hpp"

#include <cpl_conv.h>
#include <gdal.h>

#include <mutex>

namespace terravox::geo {

void start_gdal() {
    static std::once_flag once;
    std::call_once(once, [] {
        GDALAllRegister();
        if (CPLGetConfigOption("GDAL_CACHEMAX", nullptr) == nullptr) GDALSetCacheMax64(kGdalCache_bytes);
    });
}

}  // namespace terravox::geo
