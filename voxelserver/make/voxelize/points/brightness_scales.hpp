#pragma once

#include <vector>

#include "voxelserver/make/voxelize/points/sources.hpp"
#include "voxelserver/make/voxelize/points/square_sample.hpp"

namespace terravox::voxelize {

/// Brings the intensities of all files to one scale, for those whose points have no colours, and
/// counts the flight lines. A scale that is known is taken over while all files that have a part in
/// it are those of then; where echoes are not at hand, they are sampled.
/// @param known of each file, or nullptr
/// @return of each file what its scale is made of (KnownSquare::scale_of)
std::vector<voxel::Fingerprint> share_brightness(Sources& sources,
                                                 std::vector<SquareSample>& samples,
                                                 const std::vector<const KnownSquare*>& known,
                                                 const ClassTable& classes,
                                                 const Settings::Points& filters, int threads);

}  // namespace terravox::voxelize
