#pragma once

#include <gdal_priv.h>

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/geo/crs.hpp"
#include "common/geo/gdal.hpp"
#include "tests/catch.hpp"

namespace terravox::test {

/// How an image with a place on Earth is written.
struct GeoImage {
    int width = 100;
    int height = 100;
    std::array<double, 6> geo{};  ///< GDAL's order
    std::string crs = "EPSG:2154";
    GDALDataType type = GDT_Byte;
    int bands = 3;
    bool palette = false;  ///< entry i: 255 - i, i, 77
    std::optional<double> nodata = std::nullopt;
};

/// Writes a GeoTIFF. @param value_at (x, y, band) of pixels to a number
template <class ValueAt>
void write_geo_image(const std::filesystem::path& file, const GeoImage& image,
                     const ValueAt& value_at) {
    geo::start_gdal();
    const GDALDatasetUniquePtr out(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
        file.c_str(), image.width, image.height, image.bands, image.type, nullptr));
    REQUIRE(out);
    auto geo = image.geo;
    out->SetGeoTransform(geo.data());
    if (!image.crs.empty())
        out->SetSpatialRef(&geo::Crs::from_text(image.crs).ogr());
    GDALColorTable table(GPI_RGB);
    for (short i = 0; i < 256; ++i) {
        const GDALColorEntry entry{static_cast<short>(255 - i), i, 77, 255};
        table.SetColorEntry(i, &entry);
    }
    for (int b = 0; b < image.bands; ++b) {
        std::vector<std::uint16_t> pixels;
        for (int y = 0; y < image.height; ++y)
            for (int x = 0; x < image.width; ++x)
                pixels.push_back(static_cast<std::uint16_t>(value_at(x, y, b)));
        GDALRasterBand* band = out->GetRasterBand(b + 1);
        if (image.palette)
            band->SetColorTable(&table);
        if (image.nodata)
            band->SetNoDataValue(*image.nodata);
        REQUIRE(band->RasterIO(GF_Write, 0, 0, image.width, image.height, pixels.data(),
                               image.width, image.height, GDT_UInt16, 0, 0, nullptr) == CE_None);
    }
}

}  // namespace terravox::test
