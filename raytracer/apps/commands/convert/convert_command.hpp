#pragma once

#include <functional>

#include "common/util/error.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// Adds the options of `convert` to its program.
/// @return runs the command once the arguments are parsed
[[nodiscard]] std::function<util::ExitCode()> add_convert_options(CLI::App& app);

}  // namespace terravox::commands
