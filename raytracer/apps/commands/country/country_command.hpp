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

/// Adds `country plan`.
/// @return runs it once the arguments are parsed
[[nodiscard]] std::function<util::ExitCode()> add_country_plan(CLI::App& country);

/// Add `country run`, `country resume`, `country patch` and `country status`.
/// @return each runs its command once the arguments are parsed
[[nodiscard]] std::function<util::ExitCode()> add_country_run(CLI::App& country);
[[nodiscard]] std::function<util::ExitCode()> add_country_resume(CLI::App& country);
[[nodiscard]] std::function<util::ExitCode()> add_country_patch(CLI::App& country);
[[nodiscard]] std::function<util::ExitCode()> add_country_status(CLI::App& country);

}  // namespace terravox::commands
