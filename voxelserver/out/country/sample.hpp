#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "voxelserver/make/voxelize/world/lidar_world.hpp"
#include "voxelserver/out/country/plan.hpp"
#include "voxelserver/out/country/workload.hpp"
#include "voxelserver/out/export/core/job.hpp"

namespace terravox::country {

/// One measurement: what it took, and of how much.
struct SampledCost {
    double size = 0;   ///< points, or columns of voxels
    double cpu_s = 0;  ///< user and system time of this process
    double bytes = 0;  ///< of records; 0 of a decoded square
};

/// Measured costs of some places of a country.
struct Sample {
    double open_cpu_s = 0;               ///< to open the world
    std::vector<SampledCost> decoded;    ///< squares
    std::vector<SampledCost> made;       ///< columns of boxes, with the levels above them
    double peak_mib = 0;                 ///< most resident memory of this process
    std::vector<MissingSquare> damaged;  ///< squares that could not be decoded
};

/// The columns to measure: one of each stretch of the order in which they are written, the one
/// that reads the fewest points of some, so that the sample is made soon.
[[nodiscard]] std::vector<std::size_t> columns_to_sample(const Survey& survey,
                                                         const exports::Columns& columns,
                                                         std::size_t count);

/// Decodes squares and makes columns of boxes, one after the other on one thread, and measures.
/// @param job of an archive of the country
/// @param progress called after each column
[[nodiscard]] Sample take_sample(voxelize::LidarWorld& world, exports::Job& job,
                                 const Survey& survey, const exports::Columns& columns,
                                 const std::vector<std::size_t>& chosen,
                                 const std::function<void()>& progress = {});

/// The ratio of what was measured to its size, for all that there is of it.
/// Ref: Cochran, "Sampling Techniques", 3rd edition, 1977, chapter 6.
/// @param measured pairs of size and value
/// @param population number of which these are some
struct SizeAndValue {
    double size = 0;
    double value = 0;
};
[[nodiscard]] Measured measure_ratio(const std::vector<SizeAndValue>& measured, double population);

/// The whole from its parts.
/// @param shards each made alone
/// @param together all of them after each other, on one machine
[[nodiscard]] Estimate make_estimate(const Sample& sample, const std::vector<Workload>& shards,
                                     const Workload& together, std::uint64_t squares);
/// What a shard takes, made alone.
/// @param rows subtrees of each column of boxes
[[nodiscard]] PlannedShard planned(const Sample& sample, const Workload& shard, std::uint64_t rows);

}  // namespace terravox::country
