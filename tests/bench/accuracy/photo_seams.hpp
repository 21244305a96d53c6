#pragma once

#include <filesystem>

namespace terravox::bench {

/// Steps of brightness in a mosaic of photographs of one flight: root of the mean square of the
/// logarithm of albedo over the truth, of 12 columns on one side of a line less those on the other,
/// as medians over 64 columns along it.
struct SeamSteps {
    double at_borders = 0;  ///< along borders of photographs
    double elsewhere = 0;   ///< along other lines
};

/// Over photo_mosaic_survey().
/// @param folder of the survey, which is made there when it is missing
[[nodiscard]] SeamSteps measure_seams(const std::filesystem::path& folder, int threads);

}  // namespace terravox::bench
