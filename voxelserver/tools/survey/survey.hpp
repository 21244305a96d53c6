#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "voxelserver/tools/survey/orthophoto.hpp"
#include "voxelserver/tools/survey/square_model.hpp"

namespace terravox::survey {

/// What to survey. The place itself depends on the seed alone: any rectangle of squares shows its
/// part of it.
struct SurveyOptions {
    std::uint64_t seed = 7;
    double density = 8;  ///< laser pulses on each square metre on average, [0.1, 200]
    int squares_east = 1, squares_north = 1;  ///< [1, 100]
    int square_m = 1000;  ///< side of a square, [64, 1000]; a multiple of 16, or 1000
    /// South-west corner, EPSG:3794, whole metres.
    std::int64_t origin_east_m = 462000;
    std::int64_t origin_north_m = 101000;
    int threads = 0;  ///< 0 = one for each core
    /// Light and shadow in the orthophotos; nullopt: slopes are shaded a little, nothing casts a
    /// shadow.
    std::optional<PhotoLight> photo_light;
    std::filesystem::path folder;
};

/// @return the squares row by row from the south-west
[[nodiscard]] std::vector<SquareExtent> list_squares(const SurveyOptions& options);

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
/// @return the reports in the order of list_squares
/// @throws Error as soon as one square fails
std::vector<SquareReport> run_survey(
    const SurveyOptions& options,
    const std::function<void(const SquareReport&, std::size_t)>& progress);

}  // namespace terravox::survey
