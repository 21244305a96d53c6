#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "voxelserver/voxelize/points/point_parts.hpp"
#include "voxelserver/voxelize/points/sources.hpp"

namespace terravox::voxelize {

/// How much memory the points of a world may take, bytes. The world keeps the rest for boxes. What
/// these and the boxes leave, a sixth, is what decoding a square takes in addition to it.
struct PointMemory {
    std::size_t squares = 0;  ///< those of whole files
    std::size_t parts = 0;    ///< parts of files
    std::size_t columns = 0;
};

/// @param memory_bytes of the whole world @param files which of them fit decides how squares and
/// parts share: what is not needed for whole squares goes to parts
[[nodiscard]] PointMemory share_memory(std::size_t memory_bytes,
                                       std::span<const SquareSource> files);

/// What the square of a file depends on besides the file.
struct SquareRecipe {
    const grid::Frame& frame;
    const ClassTable& classes;
    const Settings& settings;
};

/// How each file is to be kept, in the order of `files`, of which the plan holds addresses.
/// @param recipe names the squares in the cache folder; nullptr = there is none
/// @throws Error for a file that cannot be found any more
[[nodiscard]] std::vector<PartedFile> plan_files(std::span<const SquareSource> files,
                                                 const PointMemory& memory,
                                                 const SquareRecipe* recipe);

}  // namespace terravox::voxelize
