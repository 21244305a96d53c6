#pragma once

#include <functional>

#include "common/util/error.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// Adds the options of `preview` to its program: a window with the progressive picture.
/// @return runs the command once the arguments are parsed
/// @throws (when run) Error when there is no display
[[nodiscard]] std::function<util::ExitCode()> add_preview_options(CLI::App& app);

}  // namespace terravox::commands
