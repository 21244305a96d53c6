#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/util/error.hpp"
#include "raytracer/scene/scene.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// Adds `analyse` to the program's commands.
/// @return runs the command once the arguments are parsed
/// @throws (when run) Error, UsageError
[[nodiscard]] std::function<util::ExitCode()> add_analyse_command(CLI::App& app);

/// The fields of a scene that an analysis has options for, in addition to those of all.
[[nodiscard]] std::vector<std::string> own_fields(core::AnalysisKind kind);

}  // namespace terravox::commands
