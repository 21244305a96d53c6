#pragma once

#include <string>
#include <vector>

#include "raytracer/core/scene/scene.hpp"

namespace terravox::commands {

/// The fields of a scene that an analysis has options for, in addition to those of all.
[[nodiscard]] std::vector<std::string> own_fields(core::AnalysisKind kind);

}  // namespace terravox::commands
