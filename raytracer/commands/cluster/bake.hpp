#pragma once

#include <string>
#include <vector>

#include "common/util/error.hpp"

namespace terravox::cluster {

/// Prepares LiDAR squares into the cache folder that the words name, so that tasks which come later
/// need not decode them.
/// @param command "render" or "animate", whose arguments `words` are
/// @param part "I/N": the I-th square (from 1 on) and each N-th after it, in the order of their
/// paths
/// @return kHoles when some could not be decoded @throws Error, UsageError
[[nodiscard]] util::ExitCode prepare_squares(const std::string& command, const std::string& part,
                                             const std::vector<std::string>& words);

}  // namespace terravox::cluster
