#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/voxel/world.hpp"

namespace terravox::heightmap {

struct ReliefOptions {
    /// Rasters of heights (common/geo/raster_gate.hpp). Where several have heights, the finer one
    /// counts, then the earlier path by name: their order here does not.
    std::vector<std::filesystem::path> rasters;
    std::vector<std::filesystem::path> orthophotos;  ///< images, or folders of them; may be empty
    double voxel_m = 1;                              ///< (0, 1000]
    std::optional<std::string> crs;                  ///< of all rasters, instead of what they say
    std::optional<double> height_unit_m;  ///< metres to a unit of height, e.g. 0.3048; nullopt:
                                          ///< what the raster or its CRS says, else 1
    std::optional<double> base_m;  ///< rock down to this height; nullopt: a little below the lowest
    std::size_t memory_bytes = std::size_t{512}
                               << 20;  ///< of what is kept: boxes, heights, colours
    int threads = 1;                   ///< how many ask at once: files kept open
};

/// A world from rasters of heights: a block of rock whose upper face is the relief, of grass, or of
/// rock where it is steep, in the colours of the orthophotos where there are any. Voxels lie as in
/// the worlds from LiDAR: x = floor(E / voxel), y = floor(H / voxel), z = floor(-N / voxel).
///
/// The surface of a column is the height at its middle, between the middles of the raster's cells;
/// where cells are finer than voxels their mean. Nothing stands where the raster has no value.
/// Coarse levels come straight from the raster and its overviews: nothing is read but what is
/// looked at. Rasters in degrees are warped to the UTM zone of their middle as they are read.
/// Thread-safe.
/// @throws UsageError for no raster, a bad voxel size or unit; Error naming a file that is missing,
/// no raster, without a place on Earth, damaged, or too large.
///     A box that touches damaged data throws Error: a hole
[[nodiscard]] std::unique_ptr<voxel::World> open_relief_world(const ReliefOptions& options);

/// Whether GDAL takes the file for a raster of heights: one band of numbers, no colours. Reads its
/// header only; false for what cannot be read.
[[nodiscard]] bool is_height_raster(const std::filesystem::path& path) noexcept;

}  // namespace terravox::heightmap
