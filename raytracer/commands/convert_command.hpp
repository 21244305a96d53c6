#pragma once

#include <functional>

#include "common/util/error.hpp"

namespace CLI {
class App;
}

namespace terravox {

/// Adds `convert`. @return what runs it
[[nodiscard]] std::function<ExitCode()> add_convert_command(CLI::App& app);

}  // namespace terravox
