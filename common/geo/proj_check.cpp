#include "common/geo/proj_check.hpp"

#include <ogr_spatialref.h>

#include "common/geo/gdal.hpp"
#include "common/geo/gdal_error_scope.hpp"

namespace terravox::geo {

namespace {

// What PROJ reads of a system depends on the memory that is left: a system that it knows already
// may still be read where another one was not.
bool has_memory() noexcept {
    try {
        check_memory_for_gdal();
        return true;
    } catch (...) {
        return false;
    }
}

}  // namespace

void check_proj_is_usable(const std::string& attempt) {
    const GdalErrorScope errors;
    constexpr int kKnownToAll = 4326;  // WGS 84
    OGRSpatialReference known;
    if (has_memory() && known.importFromEPSG(kKnownToAll) == OGRERR_NONE)
        return;
    throw ProjUnusableError(attempt +
                            ": PROJ cannot use its database (package proj-data), or lacks memory "
                            "or descriptors for it");
}

}  // namespace terravox::geo
