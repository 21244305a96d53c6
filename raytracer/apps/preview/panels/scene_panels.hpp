#pragma once

#include <string>

#include "raytracer/apps/preview/editor_state.hpp"
#include "raytracer/apps/preview/panels/form.hpp"

/// Parts of the panel that show fields of the scene. Each draws between two headings.
namespace terravox::panels {

void draw_light(preview::EditorState& editor_state, SceneForm& form);    ///< sun and sky
void draw_picture(preview::EditorState& editor_state, SceneForm& form);  ///< exposure, tone, layer
void draw_camera(preview::EditorState& editor_state, SceneForm& form);
void draw_materials(SceneForm& form);
void draw_quality(SceneForm& form);  ///< integrator, samples, detail
void draw_tiles(SceneForm& form);

}  // namespace terravox::panels
