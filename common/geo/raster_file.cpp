#include "common/geo/raster_file.hpp"

#include <array>

#include "common/geo/gdal.hpp"
#include "common/geo/gdal_error_scope.hpp"
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
    // An absolute path, so that no file's name can begin like one of GDAL's special names.
    const std::string name = fs::absolute(path).string();
    GDALDatasetUniquePtr data(GDALDataset::Open(name.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY,
                                                kRasterDrivers,
                                                overview >= 0 ? options.data() : nullptr));
    if (!data)
        fail("no raster that can be read: " + GdalErrorScope::reason() +
             "; allowed: " + kRasterFormats);
    if (data->GetRasterCount() < 1)
        fail("a raster without bands");
    return data;
}

}  // namespace terravox::geo
