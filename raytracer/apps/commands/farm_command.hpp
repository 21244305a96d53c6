#pragma once

#include <functional>

#include "common/util/error.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// Adds `farm token` and `farm certs` (how coordinators and workers know each other), `farm status`
/// (what a daemon or a coordinator is doing), `farm pause` and `farm resume`.
/// @return runs the command once the arguments are parsed
/// @throws (when run) Error, UsageError
[[nodiscard]] std::function<util::ExitCode()> add_farm_command(CLI::App& app);

}  // namespace terravox::commands
