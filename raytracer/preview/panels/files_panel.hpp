#pragma once

#include <string>
#include <vector>

#include "raytracer/preview/desk.hpp"
#include "raytracer/preview/final_render.hpp"
#include "raytracer/preview/progressive.hpp"

namespace terravox {

class SceneForm;

/// Scenes and pictures to files and back, and the final picture.
class FilesPanel {
public:
    /// @param scene_file where scenes go at first @param crew who renders final pictures
    FilesPanel(std::string scene_file, CrewOptions crew)
        : m_scene_file(std::move(scene_file)), m_crew(std::move(crew)) {}

    void draw(Desk& desk, SceneForm& form, const Progressive& picture, FinalRender& final_render);
    void save_scene(Desk& desk) const;
    void open_scene(Desk& desk) { open_scene(desk, m_scene_file); }
    void open_scene(Desk& desk, const std::string& file);
    void save_picture(Desk& desk, const Progressive& picture) const;
    void start_final(Desk& desk, FinalRender& final_render) const;
    [[nodiscard]] std::string command_line(const Desk& desk) const;

private:
    std::string m_scene_file, m_picture_file = "preview.png", m_final_files = "picture.png";
    const CrewOptions m_crew;
};

}  // namespace terravox
