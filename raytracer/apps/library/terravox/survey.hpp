#pragma once

#include <terravox/api.hpp>
#include <terravox/control.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace terravox {

/// A synthetic survey: LAZ files and orthophotos of a place that depends on the seed alone.
struct SurveyRequest {
    std::string folder;  ///< that is written
    std::uint64_t seed = 7;
    double density = 8;     ///< laser pulses on a square metre, [0.1, 200]
    int squares_east = 1;   ///< [1, 100]
    int squares_north = 1;  ///< [1, 100]
    int square_m = 1000;    ///< side of a square: a multiple of 16 in [64, 1000], or 1000
    int threads = 0;        ///< 0: one for each core
};

/// Writes a survey. Stopped, it finishes the squares that are begun.
/// @return the LAZ files
/// @throws UsageError, Error
TERRAVOX_API std::vector<std::string> make_survey(const SurveyRequest& request,
                                                  const Control& control = {});

}  // namespace terravox
