#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "voxelserver/make/voxelize/points/known_squares.hpp"
#include "voxelserver/make/voxelize/points/placer.hpp"
#include "voxelserver/make/voxelize/points/sources.hpp"

namespace terravox::voxelize {

/// How many points of a file are looked at before it is decoded, about.
inline constexpr std::size_t kSampledPoints = 4096;

/// Files of up to so many points are read whole where a sample says too little: tenths of a second.
inline constexpr std::uint64_t kFewPoints = 250'000;

/// Reads points from all over a file: all of a file of kFewPoints, of a larger one about as many,
/// from the beginnings of many parts. Unlike a sample, it does not come from a corner of a file
/// that cannot be entered in many places, and finds what is rare. Of a damaged file it ends early,
/// without an error: whoever wants the square's voxels hears of the damage.
void look_over(const pointcloud::PointSource& points, const pointcloud::PointBatchSink& sink);

/// What a few thousand points reveal about a file before it is decoded.
struct SquareSample {
    std::vector<GroundEcho> echoes;  ///< in coordinates of the file; none where points have colours
    bool has_echoes = false;         ///< also where they are not at hand
    double low = 0, high = 0;        ///< heights that nearly all points keep, file units; all do
                                     ///< where too little is known of a large file
    bool water = false;
    std::vector<PlanRect> islands;
};

/// Samples some points, and determines with them where the file lies: sets colours and extent.
/// @param source with a CRS
/// @throws Error as settle_extent()
[[nodiscard]] SquareSample take_sample(SquareSource& source, const ClassTable& classes,
                                       const Settings::Points& filters, int threads);

/// The echoes of take_sample() alone, of a file whose extent is known.
[[nodiscard]] std::vector<GroundEcho> sampled_echoes(const SquareSource& source,
                                                     const ClassTable& classes,
                                                     const Settings::Points& filters);

/// As take_sample(), from what is known of the file. The sample has no echoes.
[[nodiscard]] SquareSample known_sample(SquareSource& source, const KnownSquare& known);

/// Brings the intensities of all files to one scale, for those whose points have no colours, and
/// counts the flight lines. A scale that is known is taken over while all files that have a part in
/// it are those of then; where echoes are not at hand, they are sampled.
/// @param known of each file, or nullptr
/// @return of each file what its scale is made of (KnownSquare::scale_from)
std::vector<voxel::Fingerprint> share_brightness(Sources& sources,
                                                 std::vector<SquareSample>& samples,
                                                 const std::vector<const KnownSquare*>& known,
                                                 const ClassTable& classes,
                                                 const Settings::Points& filters, int threads);

}  // namespace terravox::voxelize
