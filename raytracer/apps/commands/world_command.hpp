#pragma once

#include <functional>

#include "common/util/error.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// Adds `world info`.
/// @return runs the command once the arguments are parsed
[[nodiscard]] std::function<util::ExitCode()> add_world_command(CLI::App& app);

}  // namespace terravox::commands
