#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/util/stage_times.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/voxelize/patch.hpp"

namespace terravox::voxelize {

/// What a LiDAR world is made from.
struct LidarWorldOptions {
    std::vector<std::filesystem::path> files;        ///< LAS, LAZ or COPC files, or folders of them
    std::vector<std::filesystem::path> orthophotos;  ///< image files or folders; may be empty
    std::string classes = "asprs";                   ///< id of a class table, or a path to one
    std::filesystem::path settings;  ///< which steps run and how; empty = config/voxelize.toml
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

struct LidarWorldStats {
    std::uint64_t points = 0;  ///< as the headers say
    std::size_t files = 0, orthophotos = 0;
    double water_cell_m = 0;  ///< edge of the cells in which water is looked for
    // Of what has been made so far:
    std::uint64_t wild_points =
        0;  ///< left out: far outside their file's bounds, or far from all others
    std::uint64_t hole_columns =
        0;  ///< inside the files' bounds, but with nothing seen around them
};

/// A tree as the vegetation step finds it: the highest place of a crown.
struct Tree {
    std::int32_t x = 0, z = 0;  ///< its column, absolute voxels
    float top = 0, ground = 0;  ///< heights, voxels (continuous)
};

enum class SquareState : std::uint8_t {
    kFetched,   ///< its points will be decoded when they are needed
    kPrepared,  ///< they are in memory or in the cache folder; of a file too large for that: it is
                ///< known where in it they lie
    kFailed,    ///< it could not be decoded
};

/// A file of a world.
struct SquareInfo {
    std::string name;  ///< the file's, without folder and ending
    std::filesystem::path file;
    ColumnRect bounds;         ///< voxels
    std::uint64_t points = 0;  ///< as the header says
    std::uint64_t bytes = 0;
    SquareState state = SquareState::kFetched;
    std::string error;  ///< one line; empty unless kFailed
};

struct WorldFacts;

/// A world made of airborne LiDAR. Boxes are made when asked for; squares are decoded once and kept
/// under a byte limit.
///
/// A box's reach holds every patch that was looked at for it: its own and the eight around; those
/// of the bodies of water that were asked for (a body so large that it is cut reaches everywhere),
/// and the surroundings of wide gaps. It does not depend on what was asked before.
class LidarWorld : public voxel::TracedWorld {
public:
    [[nodiscard]] virtual LidarWorldStats stats() const = 0;

    /// All files, by path. Cheap: looks at what is in memory, and whether files are in the cache
    /// folder.
    [[nodiscard]] virtual std::vector<SquareInfo> squares() const = 0;

    /// What is known without making a box (world_facts.hpp). Lives as long as the world.
    [[nodiscard]] virtual const WorldFacts& facts() const noexcept = 0;

    /// The ground before quantization: 64 x 64 heights in voxels (continuous), index = z * 64 + x,
    /// of the columns of box column (bx, bz); NaN outside the survey and in water. For accuracy
    /// reports.
    [[nodiscard]] virtual std::vector<float> ground_heights(std::int32_t bx, std::int32_t bz) = 0;

    /// The trees of box column (bx, bz), north to south, then west to east; none with the
    /// vegetation step switched off.
    [[nodiscard]] virtual std::vector<Tree> trees(std::int32_t bx, std::int32_t bz) = 0;
};

/// Opens the files: reads headers and a few points, and is then ready to make boxes.
/// @param times receives the time of every step
/// @throws UsageError for no files, no CRS, a bad option; Error for a damaged file
[[nodiscard]] std::unique_ptr<LidarWorld> open_lidar_world(const LidarWorldOptions& options,
                                                           util::StageTimes& times);

}  // namespace terravox::voxelize
