#pragma once

#include <functional>

#include "common/util/error.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// Adds `cluster` with its subcommands (slurm, openjd, kubernetes, bake) to the program's commands.
/// @return runs the subcommand that was given
/// @throws (when run) Error, UsageError
[[nodiscard]] std::function<util::ExitCode()> add_cluster_command(CLI::App& app);

}  // namespace terravox::commands
