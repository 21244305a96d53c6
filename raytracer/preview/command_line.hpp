#pragma once

#include <string>
#include <vector>

#include "raytracer/scene/scene.hpp"

namespace terravox::preview {

/// What renders a scene without a window, for a shell. Only fields that are not as usual are named.
/// @param scene without camera.look: what a view says stands in its other fields @param world what
/// it is taken of: inputs, and --ortho with each orthophoto
[[nodiscard]] std::string render_command_line(const scene::Scene& scene,
                                              const std::vector<std::string>& world,
                                              const std::string& picture);

}  // namespace terravox::preview
