#include "common/geo/proj_check.hpp"

#include <ogr_spatialref.h>

#include "common/geo/gdal.hpp"
#include "common/geo/gdal_error_scope.hpp"

namespace terravox::geo {

namespace {

// Where memory is short, PROJ may still find a coordinate reference system that it has read before,
// although it has just failed to read another one.
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
