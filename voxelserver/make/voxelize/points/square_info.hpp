#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "voxelserver/data/grid/patch.hpp"

namespace terravox::voxelize {

enum class SquareState : std::uint8_t {
    kFetched,  ///< its points will be decoded when they are needed
    /// They are in memory or in the cache folder; of a file too large for that: their place in it
    /// is known.
    kPrepared,
    kFailed,  ///< it could not be decoded
};

/// A file of a world.
struct SquareInfo {
    std::string name;  ///< the file's, without folder and ending
    std::filesystem::path file;
    grid::ColumnRect bounds;   ///< voxels
    std::uint64_t points = 0;  ///< as in the header
    std::uint64_t bytes = 0;
    SquareState state = SquareState::kFetched;
    std::string error;  ///< one line; empty unless kFailed
};

}  // namespace terravox::voxelize
