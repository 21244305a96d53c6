#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "voxelserver/tools/survey/survey_options.hpp"

namespace terravox::survey {

/// The result of writing one square.
struct SquareReport {
    std::string name;
    std::uint64_t points = 0;
    std::uint64_t bytes = 0;  ///< of LAZ file, orthophoto and truth
    double seconds = 0;       ///< wall time, from the start of the square to its last file
};

/// Writes all files of one square: NAME.laz, ortho/NAME.tif, truth/ground_NAME.tif,
/// truth/kind_NAME.tif and truth/truth_NAME.json; with a light for the photo truth/albedo_NAME.tif,
/// too. The bytes depend on seed, density, light and extent only.
/// @param threads at least 1; points and rasters are written in parallel by two
/// @throws Error
SquareReport survey_square(const SurveyOptions& options, const SquareExtent& extent, int threads);

/// Surveys all squares, several in parallel, and writes truth/place.json last. Memory: about 100 MB
/// for each thread and 1 km square in progress (twice as
/// much with a light for the photo), whatever the number of squares.
/// @param progress called after each square with the number finished so far; one call at a time,
/// from any thread
/// @return the reports in the order of squares_of
/// @throws Error as soon as one square fails
std::vector<SquareReport> run_survey(
    const SurveyOptions& options,
    const std::function<void(const SquareReport&, std::size_t)>& progress);

}  // namespace terravox::survey
