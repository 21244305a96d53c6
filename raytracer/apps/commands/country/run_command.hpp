#pragma once

#include <functional>

#include "common/util/error.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// Add `country run`, `country resume`, `country patch` and `country status`.
/// @return each runs its command once the arguments are parsed
[[nodiscard]] std::function<util::ExitCode()> add_country_run(CLI::App& country);
[[nodiscard]] std::function<util::ExitCode()> add_country_resume(CLI::App& country);
[[nodiscard]] std::function<util::ExitCode()> add_country_patch(CLI::App& country);
[[nodiscard]] std::function<util::ExitCode()> add_country_status(CLI::App& country);

}  // namespace terravox::commands
