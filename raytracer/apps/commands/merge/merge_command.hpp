#pragma once

#include <functional>

#include "common/util/error.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// Adds `merge` to the program's commands.
/// @return runs the command once the arguments are parsed
/// @throws (when run) Error, UsageError
[[nodiscard]] std::function<util::ExitCode()> add_merge_command(CLI::App& app);

}  // namespace terravox::commands
