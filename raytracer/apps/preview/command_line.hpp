#pragma once

#include <string>
#include <vector>

#include "raytracer/core/scene/scene.hpp"

namespace terravox::preview {

/// The shell command that renders a scene without a window. Only fields that differ from their
/// defaults are named.
/// @param scene without camera.look: a named view is expanded into the other fields
/// @param world the arguments of the world: inputs, and --ortho with each orthophoto
[[nodiscard]] std::string render_command_line(const scene::Scene& scene,
                                              const std::vector<std::string>& world,
                                              const std::string& picture);

}  // namespace terravox::preview
