#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "voxelserver/tools/survey/photo_light.hpp"
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
[[nodiscard]] std::vector<SquareExtent> squares_of(const SurveyOptions& options);

/// Parses the command line.
/// @return nullopt for --help or --version; `answer` then holds the text to print
/// @throws UsageError for an unknown flag or a value out of range
[[nodiscard]] std::optional<SurveyOptions> parse_options(int argc, const char* const* argv,
                                                         std::string& answer);

}  // namespace terravox::survey
