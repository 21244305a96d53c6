#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "voxelserver/tools/survey/square_model.hpp"

namespace terravox::survey {

/// An image of a square, north row first.
template <class Value>
struct SquareRaster {
    int side_px = 0;
    int bands = 1;
    std::vector<Value> pixels;  ///< row by row, the bands of a pixel together
};

/// Writes a tiled, deflated GeoTIFF in EPSG:3794, atomically: it appears under its name when it is
/// complete.
/// @throws Error
void write_geotiff(const std::filesystem::path& path, const SquareExtent& extent,
                   const SquareRaster<std::uint8_t>& raster);
void write_geotiff(const std::filesystem::path& path, const SquareExtent& extent,
                   const SquareRaster<float>& raster);

/// The CRS of every survey as LAS 1.4 requires it: OGC WKT 1, one line.
[[nodiscard]] std::string survey_wkt1();
inline constexpr const char* kSurveyCrs = "EPSG:3794";

}  // namespace terravox::survey
