#pragma once

#include <functional>

#include "common/util/error.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// Adds `worker`: the daemon that lends this machine to renders on other machines.
/// @return runs the command once the arguments are parsed
/// @throws (when run) Error, UsageError
[[nodiscard]] std::function<util::ExitCode()> add_worker_command(CLI::App& app);

}  // namespace terravox::commands
