#pragma once

#include <filesystem>
#include <vector>

namespace terravox::bench {

/// Nine squares side by side, each with a photograph of its own, all of one flight in thin haze:
/// village, fields, and woods in which hardly any ground is seen.
struct PhotoMosaicSurvey {
    static constexpr int kSquares = 3;  ///< to the east, and to the north
    static constexpr int kSquare_m = 256;
    std::vector<std::filesystem::path> points;
    std::vector<std::filesystem::path> photos;
    std::vector<std::filesystem::path> albedos;  ///< the photographs' colours without light
};

/// Makes the survey in a folder unless it is there.
[[nodiscard]] PhotoMosaicSurvey photo_mosaic_survey(const std::filesystem::path& folder,
                                                    int threads);

}  // namespace terravox::bench
