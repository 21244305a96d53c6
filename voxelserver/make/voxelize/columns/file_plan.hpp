#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "voxelserver/make/voxelize/points/point_parts.hpp"
#include "voxelserver/make/voxelize/points/sources.hpp"

namespace terravox::voxelize {

/// How much memory the points of a world may take, bytes. The rest is for boxes, except for a sixth
/// of the world's memory, which is left for decoding a square.
struct PointMemory {
    std::size_t squares = 0;  ///< those of whole files
    std::size_t parts = 0;    ///< parts of files
    std::size_t columns = 0;
};

/// @param memory_bytes of the whole world
/// @param files determine how squares and parts share the memory: what whole squares do not need
/// goes to parts
[[nodiscard]] PointMemory share_memory(std::size_t memory_bytes,
                                       std::span<const SquareSource> files);

/// What the square of a file depends on in addition to the file.
struct SquareRecipe {
    const grid::Frame& frame;
    const ClassTable& classes;
    const Settings& settings;
};

/// How each file is to be kept, in the order of `files`. The plan points into `files`.
/// @param recipe names the squares in the cache folder; nullptr = there is none
[[nodiscard]] std::vector<PartedFile> plan_files(std::span<const SquareSource> files,
                                                 const PointMemory& memory,
                                                 const SquareRecipe* recipe);

}  // namespace terravox::voxelize
