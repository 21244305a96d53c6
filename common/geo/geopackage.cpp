#include "common/geo/geopackage.hpp"

#include <gdal_priv.h>
#include <ogrsf_frmts.h>

#include "common/geo/gdal.hpp"
#include "common/util/error.hpp"

namespace terravox::geo {

GDALDriverH geopackage_driver() {
    start_gdal();
    static GDALDriver* const driver = [] {
        RegisterOGRGeoPackage();
        GDALDriver* const out = GetGDALDriverManager()->GetDriverByName("GPKG");
        if (out != nullptr)
            GetGDALDriverManager()->DeregisterDriver(out);
        return out;
    }();
    if (driver == nullptr)
        throw util::Error("write a GeoPackage: this GDAL was built without them");
    return driver;
}

}  // namespace terravox::geo
