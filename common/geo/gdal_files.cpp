#include "common/geo/gdal_files.hpp"

#include <dlfcn.h>
#include <gdal_priv.h>
#include <ogrsf_frmts.h>
#include <array>
#include <string>

#include "common/geo/gdal.hpp"
#include "common/geo/gdal_messages.hpp"
#include "common/geo/raster_gate.hpp"
#include "common/util/error.hpp"

namespace terravox::geo {

namespace fs = std::filesystem;

GDALDatasetUniquePtr open_raster(const fs::path& path, const std::string& attempt, int overview) {
    start_gdal();
    const GdalErrorScope errors;
    const auto fail = [&](const std::string& what) {
        throw util::Error(attempt + " " + path.string() + ": " + what);
    };
    std::error_code failed;
    const fs::file_status status = fs::status(path, failed);
    if (!fs::exists(status))
        fail("no such file");
    if (!fs::is_regular_file(status))
        fail("no file, but a folder or a device");
    const std::string level = "OVERVIEW_LEVEL=" + std::to_string(overview);
    const std::array<const char*, 2> options{level.c_str(), nullptr};
    // GDAL takes the type of a grid of text from its first lines: behind whole numbers it would
    // read "nan" as 0.
    const CPLConfigOptionSetter any_number("AAIGRID_DATATYPE", "Float64", false);
    // An absolute path, so that no file's name can begin like one of GDAL's special names.
    const std::string name = fs::absolute(path).string();
    GDALDatasetUniquePtr data(GDALDataset::Open(name.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY,
                                                kRasterDrivers,
                                                overview >= 0 ? options.data() : nullptr));
    if (!data) {
        const std::string reason = GdalErrorScope::reason();
        const std::string message = attempt + " " + path.string() +
                                    ": no raster that can be read: " + reason +
                                    "; allowed: " + kRasterFormats;
        // Where none of its drivers knows a file GDAL says nothing, or that it is not recognized.
        if (CPLGetLastErrorNo() != CPLE_None &&
            reason.find("not recognized as") == std::string::npos)
            throw RasterError(message, reason);
        throw util::Error(message);
    }
    if (data->GetRasterCount() < 1)
        fail("a raster without bands");
    return data;
}

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
        throw util::Error("write a {}: this GDAL was built without them", what);
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
