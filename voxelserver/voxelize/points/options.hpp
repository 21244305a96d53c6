#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace terravox::voxelize {

/// What a LiDAR world is made from.
struct LidarWorldOptions {
    std::vector<std::filesystem::path> files;        ///< of points, or folders of them
    std::vector<std::filesystem::path> orthophotos;  ///< image files or folders; may be empty
    std::string classes = "asprs";                   ///< id of a class table, or a path to one
    std::filesystem::path settings;  ///< which steps run and how; empty = config/voxelize.toml
    std::string steps;  ///< which of them run, over the settings (switch_steps); empty = no change
    std::optional<std::string> crs;  ///< overrides what the files say
    std::optional<std::string>
        vertical_unit;  ///< "m", "ft" or "us-ft"; default: from the CRS, else its horizontal unit
    double voxel_m = 1;
    std::size_t memory_bytes =
        std::size_t{4}
        << 30;  ///< for decoded squares, columns and boxes together; 24 MiB are taken at least
    int threads = 0;  ///< 0 = one for each core
    /// Folder in which prepared squares are kept, so that a restart need not decode them again;
    /// empty = nothing is kept on disk.
    std::filesystem::path cache_dir;
    std::uint64_t cache_bytes = std::uint64_t{20}
                                << 30;  ///< of cache_dir: what was used longest ago goes first
};

}  // namespace terravox::voxelize
