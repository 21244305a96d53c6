#pragma once

#include <functional>

#include "common/util/error.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// Adds `country plan`.
/// @return runs it once the arguments are parsed
[[nodiscard]] std::function<util::ExitCode()> add_country_plan(CLI::App& country);

}  // namespace terravox::commands
