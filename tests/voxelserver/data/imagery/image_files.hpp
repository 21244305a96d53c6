#pragma once

#include <cmath>
#include <string>

#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/image_file.hpp"
#include "voxelserver/data/imagery/orthophotos.hpp"

namespace terravox::test {

inline grid::Frame frame(double voxel_m = 1) {
    return {geo::Crs::from_text(kCrs), voxel_m, kEast0, kNorth0};
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
