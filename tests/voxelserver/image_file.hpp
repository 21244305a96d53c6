#pragma once

#include <gdal_priv.h>

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/geo/crs.hpp"
#include "common/geo/gdal.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/place.hpp"

namespace terravox::test {

/// How a test image is written.
struct ImageFile {
    int width = 100;
    int height = 100;
    int bands = 3;
    std::array<double, 6> geo{kEast0, 1, 0, kNorth0 + 100, 0, -1};  ///< GDAL's order
    std::string crs = kCrs;
    GDALDataType type = GDT_Byte;
    bool palette = false;  ///< entry i: 255 - i, i, 77
    std::optional<double> nodata{};
    std::string unit{};                       ///< of the bands
    double scale = 1;                         ///< of the bands
    std::vector<int> overviews{};             ///< their factors
    std::string date{};                       ///< TIFFTAG_DATETIME
    std::vector<std::string> descriptions{};  ///< of the bands
    std::vector<GDALColorInterp>
        meanings{};                      ///< of the bands; those not named stay as GDAL makes them
    std::vector<std::string> options{};  ///< of the driver
    /// @param x, y pixel  @param band from 0
    std::function<double(int x, int y, int band)> value = [](int, int, int) { return 100; };
};

inline void write_image(const std::filesystem::path& file, const ImageFile& image) {
    geo::start_gdal();
    std::vector<const char*> options;
    for (const auto& option : image.options)
        options.push_back(option.c_str());
    options.push_back(nullptr);
    GDALDatasetUniquePtr out(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
        file.string().c_str(), image.width, image.height, image.bands, image.type,
        const_cast<char**>(options.data())));
    REQUIRE(out);
    auto geo = image.geo;
    if (geo[1] != 0)
        out->SetGeoTransform(geo.data());
    if (!image.crs.empty())
        out->SetSpatialRef(&geo::Crs::from_text(image.crs).ogr());
    if (!image.date.empty())
        out->SetMetadataItem("TIFFTAG_DATETIME", image.date.c_str());
    GDALColorTable table(GPI_RGB);
    for (short i = 0; i < 256; ++i) {
        const GDALColorEntry entry{static_cast<short>(255 - i), i, 77, 255};
        table.SetColorEntry(i, &entry);
    }
    for (int b = 0; b < image.bands; ++b) {
        GDALRasterBand* band = out->GetRasterBand(b + 1);
        if (image.palette)
            band->SetColorTable(&table);
        const auto i = static_cast<std::size_t>(b);
        if (i < image.meanings.size())
            band->SetColorInterpretation(image.meanings[i]);
        if (i < image.descriptions.size())
            band->SetDescription(image.descriptions[i].c_str());
        if (image.nodata)
            band->SetNoDataValue(*image.nodata);
        if (!image.unit.empty())
            band->SetUnitType(image.unit.c_str());
        if (image.scale != 1)
            band->SetScale(image.scale);
    }
    std::vector<double> row(static_cast<std::size_t>(image.width));
    for (int b = 0; b < image.bands; ++b)
        for (int y = 0; y < image.height; ++y) {
            for (int x = 0; x < image.width; ++x)
                row[static_cast<std::size_t>(x)] = image.value(x, y, b);
            REQUIRE(out->GetRasterBand(b + 1)->RasterIO(GF_Write, 0, y, image.width, 1, row.data(),
                                                        image.width, 1, GDT_Float64, 0, 0,
                                                        nullptr) == CE_None);
        }
    if (!image.overviews.empty()) {
        out->FlushCache();
        REQUIRE(out->BuildOverviews("AVERAGE", static_cast<int>(image.overviews.size()),
                                    const_cast<int*>(image.overviews.data()), 0, nullptr, nullptr,
                                    nullptr) == CE_None);
    }
}

/// Writes an image of one colour, a pixel to a metre. @param east, north of its south-western
/// corner
inline void write_one_colour(const std::filesystem::path& file, double east, double north,
                             double width, double height, std::array<int, 3> colour) {
    write_image(file, {.width = static_cast<int>(width),
                       .height = static_cast<int>(height),
                       .geo = {kEast0 + east, 1, 0, kNorth0 + north + height, 0, -1},
                       .value = [&](int, int, int band) {
                           return colour[static_cast<std::size_t>(band)];
                       }});
}

}  // namespace terravox::test
