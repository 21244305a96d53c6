#pragma once

#include <vector>

#include "voxelserver/data/grid/square_names.hpp"
#include "voxelserver/make/voxelize/points/known_squares.hpp"
#include "voxelserver/make/voxelize/points/options.hpp"
#include "voxelserver/make/voxelize/points/placer.hpp"
#include "voxelserver/make/voxelize/points/tints.hpp"

namespace terravox::voxelize {

/// All files of a world, placed in one frame. Immutable once made.
struct Sources {
    grid::Frame frame;
    /// By path: voxels must not depend on the order of the arguments.
    std::vector<SquareSource> files;
    ClassTable classes{};                      ///< of all files
    Tints tints{};                             ///< empty where colours are not varied
    grid::ColumnRect bounds{};                 ///< of all files together
    std::int32_t lowest_y = 0, highest_y = 0;  ///< no kept point lies outside [lowest_y, highest_y)
    std::int32_t floor_y = 0;                  ///< the terrain is solid from here up
    /// Of those, without single points far from the others; nullopt: all of them.
    std::optional<voxel::HeightRange> typical_heights{};
    std::uint64_t point_count = 0;  ///< as in the headers
    bool has_water_class = false;   ///< some of the sampled points are of a water class
    double density = 0;             ///< points for each column, on average
    /// The squares whose place the names of files state, where the files lie there.
    std::vector<grid::NamedSquare> named_squares{};
    /// Of files without colours, whose points have a brightness (BrightnessScale).
    std::size_t flight_lines = 0;
    KnownSquares known_before{};  ///< what LidarWorldOptions::known_squares said
    KnownSquares known{};  ///< what was found of the files, for LidarWorldOptions::known_squares
};

/// Reads all headers and a small sample of points of each file that is not known; decodes nothing
/// else unless a header disagrees with the sample (extent.hpp), or the sample of a small file lies
/// in a part of it.
/// @throws UsageError for no files, no CRS, or files too far apart; Error for a file that cannot be
/// read or placed
[[nodiscard]] Sources open_sources(const LidarWorldOptions& options, const Settings& settings);

}  // namespace terravox::voxelize
