#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace terravox {

/// Faces of a voxel, by their outward normals.
enum class Face : std::int8_t {
    kNone = -1,  ///< nothing was hit, or the ray began inside of the voxel
    kWest = 0,
    kEast = 1,
    kBottom = 2,
    kTop = 3,
    kNorth = 4,
    kSouth = 5,
};

struct CastOptions {
    int level = 0;                                             ///< of the voxels that rays meet
    double range_m = std::numeric_limits<double>::infinity();  ///< how far rays go
    int threads = 0;                                           ///< 0: one for each core
};

/// What rays hit, one element of each array for each ray.
struct RayHits {
    std::vector<double> distance_m;                  ///< infinity: nothing was hit; NaN: a hole was
    std::vector<std::array<std::int32_t, 3>> voxel;  ///< of the level; 0, 0, 0 where nothing is hit
    std::vector<Face> face;
    std::vector<std::uint8_t> material;  ///< number of terravox::materials(); 0: nothing was hit
    std::size_t holes = 0;               ///< rays that ended at a box that could not be read
};

/// Whether something is in the way of rays.
struct Occlusion {
    std::vector<std::uint8_t> occluded;  ///< 1: something is, or a box could not be read
    std::size_t holes = 0;               ///< rays that met a box that could not be read
};

}  // namespace terravox
