#include "common/geo/proj_check.hpp"

#include <ogr_spatialref.h>

#include "common/geo/gdal_error_scope.hpp"

namespace terravox::geo {

void check_proj_is_usable(const std::string& attempt) {
    const GdalErrorScope errors;
    constexpr int kKnownToAll = 4326;  // WGS 84
    OGRSpatialReference known;
    if (known.importFromEPSG(kKnownToAll) == OGRERR_NONE)
        return;
    throw ProjUnusableError(attempt +
                            ": PROJ cannot use its database (package proj-data), or lacks memory "
                            "or descriptors for it");
}

}  // namespace terravox::geo
