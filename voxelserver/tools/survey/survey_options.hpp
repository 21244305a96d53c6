#pragma once

#include <optional>

#include "voxelserver/tools/survey/survey.hpp"

namespace terravox::survey {

/// Parses the command line.
/// @param exit_code what the program ends with, where it has nothing more to do than what was
/// printed (--help, --version)
/// @return nullopt with an exit code
/// @throws UsageError for an unknown flag or a value out of range
[[nodiscard]] std::optional<SurveyOptions> parse_options(int argc, const char* const* argv,
                                                         std::optional<int>& exit_code);

}  // namespace terravox::survey
