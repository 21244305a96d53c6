#pragma once

#include <functional>

#include "common/util/error.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// Adds `map` to the program's commands: a world from above, as a GeoTIFF or as tiles for the web.
/// @return runs the command once the arguments are parsed
/// @throws (when run) Error, UsageError
[[nodiscard]] std::function<util::ExitCode()> add_map_command(CLI::App& app);

}  // namespace terravox::commands
