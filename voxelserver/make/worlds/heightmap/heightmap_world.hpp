#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/voxel/world.hpp"
#include "voxelserver/make/worlds/kind/world_kind.hpp"

namespace terravox::heightmap {

struct HeightmapOptions {
    /// Rasters of heights (common/geo/raster_gate.hpp). Where several have heights, the finer one
    /// counts, then the one first by name: their order here does not matter.
    std::vector<std::filesystem::path> rasters;
    std::vector<std::filesystem::path> orthophotos;  ///< images, or folders of them; may be empty
    double voxel_m = 1;                              ///< (0, 1000]
    std::optional<std::string> crs;                  ///< of all rasters, overrides their own
    /// Metres to a unit of height, e.g. 0.3048; nullopt: from the raster or its CRS, else 1.
    std::optional<double> height_unit_m;
    std::optional<double> base_m;  ///< rock down to this height; nullopt: a little below the lowest
    /// For caches: boxes, heights, colours.
    std::size_t memory_bytes = std::size_t{512} << 20;
    int threads = 1;  ///< how many threads read at once: determines how many files are kept open
};

/// A world from rasters of heights: a block of rock whose upper face is the heightmap, of grass, or
/// of rock where it is steep, in the colours of the orthophotos where there are any. Voxels lie as
/// in the worlds from LiDAR: x = floor(E / voxel), y = floor(H / voxel), z = floor(-N / voxel).
///
/// The surface of a column is the height at its middle, interpolated between the middles of the
/// raster's cells; where cells are finer than voxels, it is their mean. Where the raster has no
/// value the column is empty. Coarse levels are read directly from the raster and its overviews:
/// only what is viewed is read. Rasters in degrees are warped to the UTM zone of their middle as
/// they are read. Thread-safe.
///
/// A box that touches damaged data throws Error: a hole.
/// @throws UsageError for no raster, a bad voxel size or unit; Error naming a file that is missing,
/// not a raster, not georeferenced, damaged, or too large
[[nodiscard]] std::unique_ptr<voxel::World> open_heightmap_world(const HeightmapOptions& options);

/// Why a raster is not read as heights, as the end of a message: it has other bands, colours, or
/// cannot be read. Reads only its header.
/// @return empty: it has heights; nullopt: no format of rasters knows the file
[[nodiscard]] std::optional<std::string> fault_of_raster(const std::filesystem::path& path);

/// Whether GDAL reads the file as a raster of heights: one band of numbers, no colours. Reads only
/// its header; false for a file that cannot be read.
[[nodiscard]] bool is_height_raster(const std::filesystem::path& path) noexcept;

}  // namespace terravox::heightmap

namespace terravox::worlds {

/// Rasters of heights, or folders of them.
extern const WorldKind kHeightmapKind;

}  // namespace terravox::worlds
