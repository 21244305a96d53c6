#include "raytracer/apps/preview/app/app.hpp"

#include <imgui.h>

#include <algorithm>

#include "common/util/error.hpp"
#include "raytracer/apps/preview/panels/form.hpp"
#include "raytracer/apps/preview/panels/panels.hpp"

namespace terravox::preview {
namespace {

constexpr float kWidth_ems = 28;

void draw_buttons(EditorState& editor_state) {
    if (panels::widgets::button("Undo", editor_state.can_undo()))
        editor_state.undo();
    ImGui::SameLine();
    if (panels::widgets::button("Redo", editor_state.can_redo()))
        editor_state.redo();
    ImGui::SameLine();
    if (panels::widgets::button("Flight (F4)"))
        editor_state.shows_path = !editor_state.shows_path;
    ImGui::SameLine();
    if (panels::widgets::button(editor_state.light ? "Dark (F7)" : "Light (F7)"))
        editor_state.light = !editor_state.light;
    ImGui::SameLine();
    if (panels::widgets::button("Help (F1)"))
        editor_state.shows_help = !editor_state.shows_help;
}

/// @return whether the section below it is open
bool draw_heading(const char* name, ImGuiTreeNodeFlags flags) {
    const bool shows = ImGui::CollapsingHeader(name, flags);
    panels::widgets::report_place(name);
    return shows;
}

/// @param before the scene before this frame's changes
void refuse_without_camera(EditorState& editor_state, const scene::Scene& before) {
    if (editor_state.scene == before)
        return;
    try {
        const voxel::WorldInfo& world = editor_state.info();
        (void)scene::make_camera(editor_state.scene, world, world.camera_bounds());
    } catch (const util::Error& e) {
        editor_state.scene = before;
        editor_state.notify(e.what(), true);
    }
}

}  // namespace

float SidePanel::width_px(const EditorState& editor_state, std::array<int, 2> window_px) {
    if (!editor_state.shows_panel)
        return 0;
    return std::min(kWidth_ems * ImGui::GetFontSize(), static_cast<float>(window_px[0]));
}

void SidePanel::draw(EditorState& editor_state, PickTool& pick, LivePicture& picture,
                     FinalRender& final_render, std::array<int, 2> window_px) {
    if (!editor_state.shows_panel)
        return;
    ImGui::SetNextWindowPos({0, 0});
    ImGui::SetNextWindowSize({width_px(editor_state, window_px), static_cast<float>(window_px[1])});
    ImGui::Begin("Terravox", nullptr,
                 ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse |
                     ImGuiWindowFlags_NoBringToFrontOnFocus | ImGuiWindowFlags_NoFocusOnAppearing);
    draw_buttons(editor_state);
    scene::Scene usual = editor_state.opened;
    panels::SceneForm form(editor_state.scene, usual);
    const scene::Scene before = editor_state.scene;
    draw_sections(editor_state, form, pick, picture, final_render);
    ImGui::End();
    if (!form.problem().empty())
        editor_state.notify(form.problem(), true);
    refuse_without_camera(editor_state, before);
}

void SidePanel::draw_sections(EditorState& editor_state, panels::SceneForm& form, PickTool& pick,
                              LivePicture& picture, FinalRender& final_render) {
    constexpr ImGuiTreeNodeFlags kOpen = ImGuiTreeNodeFlags_DefaultOpen;
    constexpr ImGuiTreeNodeFlags kClosed = ImGuiTreeNodeFlags_None;
    if (draw_heading("Sun and sky", kOpen))
        panels::draw_light(editor_state, form);
    if (draw_heading("Picture", kOpen))
        panels::draw_picture(editor_state, form);
    if (draw_heading("Camera", kOpen))
        panels::draw_camera(editor_state, form);
    if (draw_heading("Places", kOpen))
        m_places.draw(editor_state, pick, picture.progressive().view());
    if (draw_heading("Materials", kClosed))
        panels::draw_materials(form);
    if (draw_heading("Quality", kClosed))
        panels::draw_quality(form);
    if (draw_heading("Tiles", kClosed))
        panels::draw_tiles(form);
    if (draw_heading("Processors", kClosed))
        m_processors.draw(editor_state, picture.render_pool());
    if (draw_heading("Files", kOpen))
        m_files.draw(editor_state, form, picture.progressive(), final_render);
}

}  // namespace terravox::preview
