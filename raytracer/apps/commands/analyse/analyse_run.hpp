#pragma once

#include "common/util/error.hpp"
#include "raytracer/apps/commands/analyse/analyse_arguments.hpp"
#include "raytracer/core/scene/scene.hpp"

namespace terravox::commands {

/// Measures a world and writes what the arguments ask for: a raster, or a part of its tiles, and
/// the files made of it.
/// @return kHoles where values are missing because boxes were not available
/// @throws UsageError for arguments that cannot be, before any work is done; Error, also
/// "interrupted" when stopped by a signal
[[nodiscard]] util::ExitCode run_analyse(const AnalyseArguments& args, core::AnalysisKind kind);

}  // namespace terravox::commands
