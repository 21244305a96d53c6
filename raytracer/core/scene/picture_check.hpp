#pragma once

#include "raytracer/core/scene/scene.hpp"

namespace terravox::scene {

/// @throws UsageError for the scene of an analysis: its pixels are measured values, not light
void check_is_picture(const Scene& scene);

}  // namespace terravox::scene
