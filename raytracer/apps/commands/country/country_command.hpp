#pragma once

#include <functional>

#include "common/util/error.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// Adds `country` with its commands.
/// @return runs the one that was given, once the arguments are parsed
[[nodiscard]] std::function<util::ExitCode()> add_country_command(CLI::App& app);

/// Adds the commands of a plan that is there: `country run`, `resume`, `patch` and `status`.
/// @return runs the one that was given, once the arguments are parsed
[[nodiscard]] std::function<util::ExitCode()> add_country_runs(CLI::App& country);

}  // namespace terravox::commands
