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

}  // namespace terravox::commands
