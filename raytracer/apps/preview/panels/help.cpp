#include "raytracer/apps/preview/panels/help.hpp"

#include <imgui.h>

namespace terravox::panels {
namespace {

struct Line {
    const char *keys, *what;
};
constexpr std::array kLines{
    Line{"left drag", "circle what you look at; fly: turn your head"},
    Line{"right drag", "move along the ground"},
    Line{"wheel, PgUp, PgDn", "nearer, farther"},
    Line{"W A S D, Q E", "move; down, up. Shift: fast, Alt: slowly"},
    Line{"arrows", "turn"},
    Line{"click, double click", "read a voxel; look at it"},
    Line{"V", "read the voxel in the middle of the picture"},
    Line{"F", "fly or orbit"},
    Line{"Home", "the whole world"},
    Line{"M", "measure: click on both ends"},
    Line{"[ ]", "a quarter of an hour earlier, later"},
    Line{"- =", "darker, brighter"},
    Line{"K, P", "add a key frame, play the flight"},
    Line{"F1 F2 F3 F4", "help, panel, map, flight"},
    Line{"F5 F6, F7, F8", "layers, light or dark, the final picture's aspect ratio or fill"},
    Line{"Ctrl+Z, Ctrl+Y", "undo, redo"},
    Line{"Ctrl+S, O, P, R, K",
         "save or open the scene, save the picture, render, copy the command"},
    Line{"Ctrl+Tab, arrows", "by keyboard: to the panel, from field to field"},
    Line{"Space, Enter", "there: change by arrows, type a value"},
    Line{"Esc, Ctrl+Q", "leave what you do, quit"}};

}  // namespace

void draw_help(preview::EditorState& editor_state, std::array<int, 2> window_px) {
    if (!editor_state.shows_help)
        return;
    ImGui::SetNextWindowPos(
        {static_cast<float>(window_px[0]) / 2, static_cast<float>(window_px[1]) / 2},
        ImGuiCond_Always, {0.5f, 0.5f});
    ImGui::Begin(
        "Help", &editor_state.shows_help,
        ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse);
    for (const Line& line : kLines) {
        ImGui::TextUnformatted(line.keys);
        ImGui::SameLine(ImGui::GetFontSize() * 12);
        ImGui::TextUnformatted(line.what);
    }
    ImGui::End();
}

}  // namespace terravox::panels
