#pragma once

#include <functional>

#include "common/util/error.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// Adds `convert`. @return what runs it
[[nodiscard]] std::function<util::ExitCode()> add_convert_command(CLI::App& app);

}  // namespace terravox::commands
