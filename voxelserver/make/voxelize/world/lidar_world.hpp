#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/util/stage_times.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/data/grid/patch.hpp"
#include "voxelserver/make/voxelize/points/options.hpp"
#include "voxelserver/make/voxelize/points/square_info.hpp"
#include "voxelserver/make/voxelize/steps/tree.hpp"

namespace terravox::voxelize {

struct LidarWorldStats {
    std::uint64_t points = 0;  ///< as in the headers
    std::size_t files = 0;
    std::size_t orthophotos = 0;
    double water_cell_m = 0;  ///< edge of the cells in which water is searched for
    /// Points left out of what has been made so far: far outside their file's bounds, or far from
    /// all others.
    std::uint64_t outliers = 0;
    /// Columns of what has been made so far that lie inside the files' bounds, but have no return
    /// around them.
    std::uint64_t hole_columns = 0;
    /// Flight lines from whose intensities materials are guessed, of files without colours.
    std::size_t flight_lines = 0;
    std::string class_table;  ///< its id
};

struct WorldFacts;

/// A world made of airborne LiDAR. Boxes are made on request; squares are decoded once and kept
/// under a byte limit.
///
/// A box's reach holds every patch that was read for it: its own and the eight around, with
/// photographs whose light is taken out those around that cast shadows, too; those of the
/// bodies of water that were queried (a body so large that it is cut reaches everywhere), and the
/// surroundings of wide gaps. It does not depend on earlier requests.
class LidarWorld : public voxel::ProvenanceWorld {
public:
    [[nodiscard]] virtual LidarWorldStats stats() const = 0;

    /// All files, by path. Cheap: checks only what is in memory, and whether files are in the cache
    /// folder.
    [[nodiscard]] virtual std::vector<SquareInfo> squares() const = 0;

    /// What is known without making a box (world_facts.hpp). Lives as long as the world.
    [[nodiscard]] virtual const WorldFacts& facts() const noexcept = 0;

    /// What opening has found of the files, for LidarWorldOptions::known_squares: bytes of a file.
    /// @param also identities of files that are no longer there, as for known_bounds(): what was
    /// known of them is kept
    [[nodiscard]] virtual std::string known_squares(std::span<const std::string> also) const = 0;

    /// The files whose points have other materials than before since their intensities mean
    /// something else (points/brightness.hpp); none where materials are not guessed.
    /// @param changed where files have changed, are new or gone, in columns of the world
    /// @param scales_are_known whether LidarWorldOptions::known_squares holds the scales of before:
    /// then those are meant whose scale is another one now, else all that may share one with a file
    /// that has changed
    /// @return indices into facts().squares
    [[nodiscard]] virtual std::set<std::size_t> rescaled_files(
        std::span<const grid::ColumnRect> changed, bool scales_are_known) const = 0;

    /// Where a file lay when LidarWorldOptions::known_squares was written, in columns of that
    /// world.
    /// @param identity 32 hexadecimal digits (common/voxel/fingerprint.hpp)
    /// @return nullopt when it was not known
    [[nodiscard]] virtual std::optional<grid::ColumnRect> known_bounds(
        std::string_view identity) const = 0;

    /// The ground before quantization: 64 x 64 heights in voxels (continuous), index = z * 64 + x,
    /// of the columns of box column (bx, bz); NaN outside the survey and in water. For accuracy
    /// reports.
    [[nodiscard]] virtual std::vector<float> ground_heights(std::int32_t bx, std::int32_t bz) = 0;

    /// The reach of the boxes of column (bx, bz), without making them, and of all water that the
    /// column holds or may hold.
    [[nodiscard]] virtual voxel::InputExtent reach(std::int32_t bx, std::int32_t bz) = 0;

    /// As reach(), of the patch with its neighbours and the water alone: cheaper, since no ground
    /// is made.
    [[nodiscard]] virtual voxel::InputExtent water_reach(std::int32_t bx, std::int32_t bz) = 0;

    /// The water cells of a column in which ground was seen (wide_ground.hpp).
    [[nodiscard]] virtual std::size_t ground_cells(std::int32_t bx, std::int32_t bz) = 0;

    /// Patches around a column in which the shadows on its photograph are searched for; 0: colours
    /// of photographs are left as they are.
    [[nodiscard]] virtual std::int32_t shadow_patches() const noexcept = 0;

    /// The columns of each photograph whose light is found from one of some files.
    /// @param files indices into facts().squares
    [[nodiscard]] virtual std::vector<grid::ColumnRect> photographs_with_light_from(
        const std::set<std::size_t>& files) const = 0;

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
