#include "common/geo/writing_drivers.hpp"

#include <dlfcn.h>
#include <gdal_priv.h>
#include <ogrsf_frmts.h>

#include <string>

#include "common/geo/gdal.hpp"
#include "common/util/error.hpp"

namespace terravox::geo {
namespace {

/// Registers a driver and takes it out again.
/// @param enter registers it; nullptr: GDAL has none
GDALDriver* taken_out(void (*enter)(), const char* name) {
    if (enter == nullptr)
        return nullptr;
    enter();
    GDALDriver* const out = GetGDALDriverManager()->GetDriverByName(name);
    if (out != nullptr)
        GetGDALDriverManager()->DeregisterDriver(out);
    return out;
}

/// What registers a driver that not every GDAL has: it is looked for when it is needed.
/// @return nullptr where there is none
void (*optional_driver(const char* function))() {
    return reinterpret_cast<void (*)()>(::dlsym(RTLD_DEFAULT, function));
}

GDALDriverH checked(GDALDriver* driver, const std::string& what) {
    if (driver == nullptr)
        throw util::Error("write a " + what + ": this GDAL was built without them");
    return driver;
}

}  // namespace

GDALDriverH geopackage_driver() {
    start_gdal();
    static GDALDriver* const driver = taken_out(RegisterOGRGeoPackage, "GPKG");
    return checked(driver, "GeoPackage");
}

GDALDriverH netcdf_driver() {
    start_gdal();
    static GDALDriver* const driver = taken_out(optional_driver("GDALRegister_netCDF"), "netCDF");
    return checked(driver, "netCDF file");
}

GDALDriverH webp_driver() {
    start_gdal();
    static GDALDriver* const driver = taken_out(optional_driver("GDALRegister_WEBP"), "WEBP");
    return checked(driver, "WebP picture");
}

}  // namespace terravox::geo
