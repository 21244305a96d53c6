#pragma once

#include <array>

#include "raytracer/apps/preview/live_picture.hpp"
#include "raytracer/apps/preview/panels/files_panel.hpp"
#include "raytracer/apps/preview/panels/form.hpp"
#include "raytracer/apps/preview/panels/places_panel.hpp"
#include "raytracer/apps/preview/panels/processors_panel.hpp"
#include "raytracer/apps/preview/pick_tool.hpp"

namespace terravox::preview {

/// The panel at the left edge of the window: the fields of the scene, places, processors and files,
/// each below a heading. Main thread only.
class SidePanel {
public:
    explicit SidePanel(panels::FilesPanel files) : m_files(std::move(files)) {}

    /// Draws nothing while the panel is hidden. A change after which no camera can be placed is
    /// refused.
    void draw(EditorState& editor_state, PickTool& pick, LivePicture& picture,
              FinalRender& final_render, std::array<int, 2> window_px);
    /// @return pixels that the panel takes from the window; 0 while it is hidden
    [[nodiscard]] static float width_px(const EditorState& editor_state,
                                        std::array<int, 2> window_px);
    [[nodiscard]] panels::FilesPanel& files() noexcept { return m_files; }

private:
    void draw_sections(EditorState& editor_state, panels::SceneForm& form, PickTool& pick,
                       LivePicture& picture, FinalRender& final_render);

    panels::FilesPanel m_files;
    panels::PlacesPanel m_places;
    panels::ProcessorsPanel m_processors;
};

}  // namespace terravox::preview
