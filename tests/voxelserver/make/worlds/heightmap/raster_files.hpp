#pragma once

#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/geo/gdal.hpp"

namespace terravox::test {

/// A raster of heights to be written.
struct RasterSpec {
    int width = 100;
    int height = 80;
    std::array<double, 6> geo{460'000, 1, 0, 101'080, 0, -1};  ///< GDAL's order
    int epsg = 3794;                                           ///< 0: none
    GDALDataType type = GDT_Float32;
    std::optional<double> nodata;
    std::string unit;
    std::vector<std::string> options;
    std::vector<int> overviews;
    int bands = 1;
};

/// @param value of a band (from 1), column and row
inline std::filesystem::path write_raster(const std::filesystem::path& file, const RasterSpec& spec,
                                          const std::function<double(int, int, int)>& value) {
    geo::start_gdal();
    std::vector<char*> options;
    for (const std::string& o : spec.options)
        options.push_back(const_cast<char*>(o.c_str()));
    options.push_back(nullptr);
    GDALDatasetUniquePtr out(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
        file.c_str(), spec.width, spec.height, spec.bands, spec.type, options.data()));
    if (spec.geo[1] != 0)
        out->SetGeoTransform(const_cast<double*>(spec.geo.data()));
    if (spec.epsg != 0) {
        OGRSpatialReference crs;
        crs.importFromEPSG(spec.epsg);
        crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
        out->SetSpatialRef(&crs);
    }
    for (int b = 1; b <= spec.bands; ++b) {
        GDALRasterBand* band = out->GetRasterBand(b);
        if (spec.nodata)
            band->SetNoDataValue(*spec.nodata);
        if (!spec.unit.empty())
            band->SetUnitType(spec.unit.c_str());
        std::vector<double> row(static_cast<std::size_t>(spec.width));
        for (int y = 0; y < spec.height; ++y) {
            for (int x = 0; x < spec.width; ++x)
                row[static_cast<std::size_t>(x)] = value(b, x, y);
            if (band->RasterIO(GF_Write, 0, y, spec.width, 1, row.data(), spec.width, 1,
                               GDT_Float64, 0, 0, nullptr) != CE_None)
                throw std::runtime_error("write " + file.string());
        }
    }
    if (!spec.overviews.empty()) {
        std::vector<int> factors = spec.overviews;
        out->FlushCache();
        if (out->BuildOverviews("AVERAGE", static_cast<int>(factors.size()), factors.data(), 0,
                                nullptr, nullptr, nullptr) != CE_None)
            throw std::runtime_error("overviews");
    }
    return file;
}
inline std::filesystem::path write_heights(const std::filesystem::path& file,
                                           const RasterSpec& spec,
                                           const std::function<double(int, int)>& height) {
    return write_raster(file, spec, [&](int, int x, int y) { return height(x, y); });
}

}  // namespace terravox::test
