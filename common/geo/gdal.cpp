#include "common/geo/gdal.hpp"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <gdal.h>

#include <mutex>

#include "common/geo/gdal_messages.hpp"
#include "common/geo/raster_gate.hpp"
#include "common/util/process_memory.hpp"

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
        // Drivers that lack memory for their descriptions are registered without them.
        check_memory_for_gdal();
        CPLSetErrorHandler(print_gdal_message);
        take_tiff_messages();
        register_raster_drivers();
        limit(kGdalCache_bytes);
    });
}

void limit_gdal_cache(std::int64_t bytes) {
    start_gdal();
    limit(bytes);
}

void check_memory_for_gdal() {
    util::check_memory(kGdalHeadroom_bytes);
}

}  // namespace terravox::geo
