#pragma once

#include <gdal_priv.h>

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/geo/gdal.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "voxelserver/data/imagery/orthophotos.hpp"

namespace terravox::test {

/// Somewhere in France (EPSG:2154): the tests' places count from here, metres east and north.
inline constexpr double kEast0 = 770'000;
inline constexpr double kNorth0 = 6'277'000;
inline constexpr const char* kCrs = "EPSG:2154";

inline grid::Frame frame(double voxel_m = 1) {
    return {geo::Crs::from_text(kCrs), voxel_m, kEast0, kNorth0};
}

/// How a test image is written.
struct ImageFile {
    int width = 100;
    int height = 100;
    int bands = 3;
    std::array<double, 6> geo{kEast0, 1, 0, kNorth0 + 100, 0, -1};  ///< GDAL's order
    std::string crs = kCrs;
    GDALDataType type = GDT_Byte;
    std::optional<double> nodata;
    std::string date;                       ///< TIFFTAG_DATETIME
    std::vector<std::string> descriptions;  ///< of the bands
    std::vector<GDALColorInterp>
        meanings;                      ///< of the bands; those not named stay as GDAL makes them
    std::vector<std::string> options;  ///< of the driver
    /// @param x, y pixel  @param band from 0
    std::function<int(int x, int y, int band)> value = [](int, int, int) { return 100; };
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
    out->SetGeoTransform(geo.data());
    if (!image.crs.empty())
        out->SetSpatialRef(&geo::Crs::from_text(image.crs).ogr());
    if (!image.date.empty())
        out->SetMetadataItem("TIFFTAG_DATETIME", image.date.c_str());
    for (int b = 0; b < image.bands; ++b) {
        GDALRasterBand* band = out->GetRasterBand(b + 1);
        const auto i = static_cast<std::size_t>(b);
        if (i < image.meanings.size())
            band->SetColorInterpretation(image.meanings[i]);
        if (i < image.descriptions.size())
            band->SetDescription(image.descriptions[i].c_str());
        if (image.nodata)
            band->SetNoDataValue(*image.nodata);
    }
    for (int b = 0; b < image.bands; ++b) {
        std::vector<std::uint16_t> pixels;
        for (int y = 0; y < image.height; ++y)
            for (int x = 0; x < image.width; ++x)
                pixels.push_back(static_cast<std::uint16_t>(image.value(x, y, b)));
        REQUIRE(out->GetRasterBand(b + 1)->RasterIO(GF_Write, 0, 0, image.width, image.height,
                                                    pixels.data(), image.width, image.height,
                                                    GDT_UInt16, 0, 0, nullptr) == CE_None);
    }
}

/// A number that looks random, the same for the same pixel.
inline int noise(int x, int y, int band) {
    std::uint32_t h =
        static_cast<std::uint32_t>(x) * 0x9E3779B1U ^ static_cast<std::uint32_t>(y) * 0x85EBCA77U;
    h ^= static_cast<std::uint32_t>(band) * 0xC2B2AE3DU;
    h ^= h >> 15;
    h *= 0x2C1B3C6DU;
    h ^= h >> 12;
    h *= 0x297A2D39U;
    h ^= h >> 15;
    return static_cast<int>(h & 255U);
}

/// The absolute voxel of a place.
inline std::int32_t voxel_x(const grid::Frame& f, double east) {
    return static_cast<std::int32_t>(std::floor(f.x(kEast0 + east)));
}
inline std::int32_t voxel_z(const grid::Frame& f, double north) {
    return static_cast<std::int32_t>(std::floor(f.z(kNorth0 + north)));
}

/// One column of a raster as text, for comparing and for messages: "r,g,b nir/red", "-" for what is
/// not known.
inline std::string column_text(const imagery::Raster& raster, int x, int z) {
    if (raster.empty())
        return "- -";
    const auto i = static_cast<std::size_t>(z) * static_cast<std::size_t>(raster.width) +
                   static_cast<std::size_t>(x);
    std::string out = "-";
    if ((raster.flags[i] & imagery::Raster::kColour) != 0) {
        const auto c = raster.colour[i];
        out = std::to_string(c.r) + "," + std::to_string(c.g) + "," + std::to_string(c.b);
    }
    return out + ((raster.flags[i] & imagery::Raster::kNir) != 0
                      ? " " + std::to_string(raster.nir[i]) + "/" + std::to_string(raster.red[i])
                      : " -");
}

}  // namespace terravox::test
