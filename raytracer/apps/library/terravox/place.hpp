#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>

namespace terravox {

// Two systems of coordinates are used:
// - Map: easting and northing in the world's CRS, heights in metres. A world without a CRS has
//   metres from its origin, to the east and to the north.
// - Voxels: x to the east, y up, z to the south, of level 0. The voxel (x, y, z) covers [x, x + 1)
//   and so on. A voxel of level n has 2^n times the edge.

/// A block of map coordinates.
struct MapBounds {
    double west = 0;
    double south = 0;
    double east = 0;
    double north = 0;
    /// Metres; by default everything that is there.
    double bottom = -std::numeric_limits<double>::infinity();
    double top = std::numeric_limits<double>::infinity();
    friend bool operator==(const MapBounds&, const MapBounds&) = default;
};

/// A block of voxels of one level, half-open: min <= coordinate < max.
struct VoxelBlock {
    int level = 0;
    std::array<std::int32_t, 3> min{};
    std::array<std::int32_t, 3> max{};
    friend bool operator==(const VoxelBlock&, const VoxelBlock&) = default;
};

/// Facts of a world.
struct WorldInfo {
    std::string title;
    /// Of everything that is not air; of worlds without end, what pictures show of them.
    MapBounds bounds;
    VoxelBlock block;      ///< the same, of level 0
    double voxel_m = 1;    ///< edge of a voxel of level 0
    double map_units = 1;  ///< of the map for such an edge: voxel_m where these are metres
    int levels = 1;        ///< levels 0 to levels - 1 can be read
    std::string crs;       ///< "EPSG:3794"; empty: no place on Earth is known
    std::string crs_wkt;   ///< WKT 2
    std::optional<std::array<double, 2>> centre;  ///< latitude and longitude, degrees
    /// The azimuth of the map's north at the centre, clockwise from true north, degrees; 0 without
    /// a centre.
    double convergence_deg = 0;
    std::string licence;
    std::string attribution;
};

}  // namespace terravox
