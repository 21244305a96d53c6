#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/util/stage_times.hpp"
#include "common/voxel/world.hpp"

namespace terravox::voxelize {

/// What a LiDAR world is made from.
struct LidarWorldOptions {
    std::vector<std::filesystem::path> files;  ///< LAS, LAZ or COPC files, or folders of them
    std::vector<std::filesystem::path> orthophotos;  ///< image files or folders; may be empty
    std::string classes = "asprs";             ///< id of a class table, or a path to one
    std::optional<std::string> crs;            ///< overrides what the files say
    std::optional<std::string> vertical_unit;  ///< "m", "ft" or "us-ft"; default: from the CRS, else its horizontal unit
    double voxel_m = 1;
    std::size_t memory_bytes = std::size_t{4} << 30;  ///< for decoded squares, columns and boxes together
    int threads = 0;                           ///< 0 = one for each core
};

struct LidarWorldStats {
    std::uint64_t points = 0;         ///< as the headers say
    std::uint64_t wild_points = 0;    ///< left out: far outside their file's bounds
    std::size_t files = 0, orthophotos = 0;
    double terrain_cell_m = 0;
};

/// A world made of airborne LiDAR. Boxes are made when asked for; squares are decoded once and kept under a byte limit.
class LidarWorld : public voxel::World {
public:
    [[nodiscard]] virtual LidarWorldStats stats() const = 0;
};

/// Opens the files, decodes them once for the coarse terrain, and is then ready to make boxes.
/// @param times receives the time of every step
/// @throws UsageError for no files, no CRS, a bad option; Error for a damaged file
[[nodiscard]] std::unique_ptr<LidarWorld> open_lidar_world(const LidarWorldOptions& options, util::StageTimes& times);

}  // namespace terravox::voxelize
