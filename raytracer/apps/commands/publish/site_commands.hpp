#pragma once

#include <functional>

#include "common/util/error.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// Adds the options of `publish` to its program.
/// @return runs the command once the arguments are parsed
[[nodiscard]] std::function<util::ExitCode()> add_publish_options(CLI::App& app);

/// Adds the options of `view` to its program, which shows a site, or what it publishes for the time
/// that it runs, to a browser of this machine.
/// @return runs the command once the arguments are parsed
[[nodiscard]] std::function<util::ExitCode()> add_view_options(CLI::App& app);

}  // namespace terravox::commands
