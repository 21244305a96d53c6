#pragma once

#include "common/util/stage_times.hpp"
#include "voxelserver/data/store/chunk_index.hpp"
#include "voxelserver/make/voxelize/points/placer.hpp"

namespace terravox::voxelize {

/// What reading needs in addition to the file.
struct LoadContext {
    const grid::Frame& frame;
    const ClassTable& classes;
    const Settings& settings;
    util::StageTimes& times;
};

/// A file decoded whole.
struct LoadedSquare {
    std::shared_ptr<const store::Square> square;
    store::ChunkIndex index;
};

/// Steps "point load", "transformation", "quantization" and "binning" of a whole file, several
/// parts of it in parallel.
/// @throws Error for a damaged file, and for one that has changed since it was opened; so do the
/// next two
[[nodiscard]] LoadedSquare load_square(const SquareSource& source, const LoadContext& context,
                                       int threads);

/// The same for the points of some patches.
/// @param ranges hold all of them (from an index)
[[nodiscard]] std::shared_ptr<const store::Square> load_patches(
    const SquareSource& source, std::span<const pointcloud::PointRange> ranges,
    const grid::PatchRect& wanted, const LoadContext& context, int threads);

/// One range alone, on the calling thread.
[[nodiscard]] std::shared_ptr<const store::Square> load_range(const SquareSource& source,
                                                              const pointcloud::PointRange& range,
                                                              const LoadContext& context);

/// Decodes a file only to index which points lie where: for files too large to be kept whole.
/// @param counts receives the counts of the points
[[nodiscard]] store::ChunkIndex scan_chunks(const SquareSource& source, const LoadContext& context,
                                            int threads, store::PointCounts& counts);

}  // namespace terravox::voxelize
