#pragma once

#include <gdal_priv.h>

#include <array>
#include <filesystem>
#include <vector>

#include "common/geo/crs.hpp"
#include "common/geo/gdal.hpp"
#include "tests/catch.hpp"

namespace terravox::test {

/// Writes a GeoTIFF of one colour in EPSG:2154, a pixel to a metre. @param west, south its corner
inline void write_one_colour(const std::filesystem::path& file, double west, double south,
                             double width, double height, std::array<int, 3> colour) {
    geo::start_gdal();
    const int w = static_cast<int>(width);
    const int h = static_cast<int>(height);
    const GDALDatasetUniquePtr out(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
        file.c_str(), w, h, 3, GDT_Byte, nullptr));
    REQUIRE(out);
    std::array<double, 6> place{west, 1, 0, south + height, 0, -1};
    out->SetGeoTransform(place.data());
    out->SetSpatialRef(&geo::Crs::from_text("EPSG:2154").ogr());
    for (int b = 0; b < 3; ++b) {
        const auto value = static_cast<std::uint8_t>(colour[static_cast<std::size_t>(b)]);
        const std::vector<std::uint8_t> pixels(
            static_cast<std::size_t>(w) * static_cast<std::size_t>(h), value);
        REQUIRE(out->GetRasterBand(b + 1)->RasterIO(GF_Write, 0, 0, w, h,
                                                    const_cast<std::uint8_t*>(pixels.data()), w, h,
                                                    GDT_Byte, 0, 0, nullptr) == CE_None);
    }
}

}  // namespace terravox::test
