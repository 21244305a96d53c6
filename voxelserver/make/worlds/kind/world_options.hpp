#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "voxelserver/make/worlds/kind/procedural_settings.hpp"

namespace terravox::worlds {

/// The inputs and settings of a world of any kind. A kind of world ignores the settings that do not
/// concern it.
struct WorldOptions {
    /// Paths or addresses, all of one kind (voxelserver/make/worlds/open/world_kinds.hpp); several
    /// only of LiDAR data and rasters of heights.
    std::vector<std::string> inputs;
    /// Files of points that the inputs name and that are not opened.
    std::vector<std::filesystem::path> left_out;
    /// Images, or folders of them, for LiDAR data, stores and rasters of heights.
    std::vector<std::filesystem::path> orthophotos;

    /// Planned objects that are put into the world (voxelserver/make/worlds/overlay/additions.hpp).
    std::vector<std::string> additions;

    std::string title;               ///< of a world of LiDAR data; empty: by the inputs
    std::string crs;                 ///< overrides that of the files; empty: theirs
    std::string classes = "asprs";   ///< id of a LiDAR class table, or a path to one
    std::string vertical_unit;       ///< "m", "ft" or "us-ft"; empty: from the files
    std::filesystem::path settings;  ///< of voxelization; empty: config/voxelize.toml
    std::string steps;               ///< of voxelization that run; empty: as in the settings
    std::string photo;               ///< "raw" or "albedo" (LiDAR data); empty: as in the settings
    double voxel_m = 1;              ///< edge of a voxel at level 0, metres
    std::string dimension = "overworld";  ///< of a Minecraft world
    /// For rasters of heights: rock down to this height, metres; default: a little below the
    /// lowest.
    std::optional<double> base_m;
    /// For procedural worlds. Its voxel_m is not used, the one above is; a seed in the input
    /// overrides its seed.
    procedural::Settings generated;

    /// What an earlier opening has found of LiDAR files (LidarWorldOptions); empty: nothing.
    std::filesystem::path known_squares;
    std::filesystem::path chunk_indices;  ///< of LiDAR files (LidarWorldOptions); empty: none
    bool reads_chunk_indices = false;     ///< rather than only write them

    std::size_t memory_bytes = std::size_t{4} << 30;  ///< decoded squares, chunks and columns
    int threads = 0;                                  ///< 0: one for each core
    std::filesystem::path cache_dir;  ///< keeps prepared LiDAR squares; empty: nothing is kept
    std::uint64_t cache_bytes = std::uint64_t{20} << 30;  ///< limit of cache_dir
    std::chrono::seconds box_timeout{300};  ///< for each box of a voxel server or remote archive
};

}  // namespace terravox::worlds
