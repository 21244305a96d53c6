#include "common/geo/gdal.hpp"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <gdal.h>
#include <sys/mman.h>

#include <mutex>
#include <new>

#include "common/geo/gdal_messages.hpp"
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
        // Drivers that lack memory for their descriptions are registered without them.
        check_memory_for_gdal();
        CPLSetErrorHandler(print_gdal_message);
        register_raster_drivers();
        limit(kGdalCache_bytes);
    });
}

void limit_gdal_cache(std::int64_t bytes) {
    start_gdal();
    limit(bytes);
}

void check_memory_for_gdal() {
    // Mapped rather than allocated: a compiler may optimise away an unused allocation.
    void* const room = ::mmap(nullptr, kGdalHeadroom_bytes, PROT_READ | PROT_WRITE,
                              MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (room == MAP_FAILED)
        throw std::bad_alloc();
    ::munmap(room, kGdalHeadroom_bytes);
}

}  // namespace terravox::geo
