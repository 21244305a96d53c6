#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "raytracer/core/output/gdal_writing.hpp"
#include "raytracer/core/output/picture_info.hpp"

namespace terravox::analyse {

/// A variable of a file with a dimension of time.
struct CubeVariable {
    const char* name;
    const char* long_name;
};

/// Writes the first bands of a dataset as a netCDF file (CF conventions, netCDF-4, compressed): one
/// variable by time, y and x.
/// @param bands georeferenced, of one type, with a value for no data
/// @param times_s seconds since 1970-01-01 00:00 UTC of the first bands, rising
/// @param info its texts of source and licence become attributes
/// @throws Error
void write_netcdf(GDALDatasetH bands, const std::string& attempt, const CubeVariable& variable,
                  std::span<const std::int64_t> times_s, const std::filesystem::path& out,
                  const output::PictureInfo& info);

}  // namespace terravox::analyse
