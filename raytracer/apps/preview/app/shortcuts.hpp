#pragma once

#include "raytracer/apps/preview/live_picture.hpp"
#include "raytracer/apps/preview/panels/files_panel.hpp"
#include "raytracer/apps/preview/panels/path_panel.hpp"
#include "raytracer/apps/preview/pick_tool.hpp"
#include "raytracer/apps/preview/window.hpp"

namespace terravox::preview {

/// The objects that keys act on.
struct ShortcutTargets {
    Window& window;
    EditorState& editor_state;
    const Progressive& picture;
    FinalRender& final_render;
    panels::FilesPanel& files;
    panels::PathPanel& path;
    PickTool& pick;
    Pane pane;  ///< of the picture
};

/// Executes the commands of the keys of this frame, except for those that move the viewpoint
/// (Navigator). To be called after Dear ImGui has begun the frame; main thread only.
void handle_shortcuts(const ShortcutTargets& on);

}  // namespace terravox::preview
