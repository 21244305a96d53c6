#pragma once

#include <string>

#include "raytracer/preview/desk.hpp"
#include "raytracer/preview/panels/form.hpp"

/// Parts of the panel that show fields of the scene. Each draws between two headings.
namespace terravox::panels {

void draw_light(Desk& desk, SceneForm& form);    ///< sun and sky
void draw_picture(Desk& desk, SceneForm& form);  ///< exposure, tone, layer
void draw_camera(Desk& desk, SceneForm& form);
void draw_materials(SceneForm& form);
void draw_quality(SceneForm& form);  ///< integrator, samples, detail
void draw_tiles(SceneForm& form);

}  // namespace terravox::panels
