#pragma once

#include <string>
#include <vector>

#include "raytracer/apps/preview/editor_state.hpp"
#include "raytracer/apps/preview/final_render.hpp"
#include "raytracer/apps/preview/progressive.hpp"

namespace terravox::panels {

class SceneForm;

/// Saves and opens scenes, saves pictures, and starts the final picture.
class FilesPanel {
public:
    /// @param scene_file file name that is offered at first
    /// @param render_pool options for final pictures
    FilesPanel(std::string scene_file, render::RenderPoolOptions render_pool)
        : m_scene_file(std::move(scene_file)), m_render_pool(std::move(render_pool)) {}

    void draw(preview::EditorState& editor_state, SceneForm& form,
              const preview::Progressive& picture, preview::FinalRender& final_render);
    void save_scene(preview::EditorState& editor_state) const;
    void open_scene(preview::EditorState& editor_state) { open_scene(editor_state, m_scene_file); }
    void open_scene(preview::EditorState& editor_state, const std::string& file);
    void save_picture(preview::EditorState& editor_state,
                      const preview::Progressive& picture) const;
    void start_final(preview::EditorState& editor_state, preview::FinalRender& final_render) const;
    [[nodiscard]] std::string command_line(const preview::EditorState& editor_state) const;

private:
    std::string m_scene_file;
    std::string m_picture_file = "preview.png";
    std::string m_final_files = "picture.png";
    const render::RenderPoolOptions m_render_pool;
};

}  // namespace terravox::panels
