#pragma once

#include <functional>

#include "common/util/error.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// Adds `farm certs` (certificates for coordinators and workers) and `farm status` (what a daemon
/// or a coordinator is doing).
/// @return runs the command once the arguments are parsed
/// @throws (when run) Error, UsageError
[[nodiscard]] std::function<util::ExitCode()> add_farm_command(CLI::App& app);

}  // namespace terravox::commands
