#include <fmt/core.h>
#include <imgui.h>
#include <algorithm>
#include <array>
#include <string>

#include "raytracer/apps/preview/panels/panels.hpp"

namespace terravox::panels {
namespace {

constexpr double kNotice_s = 6;
constexpr double kBadNotice_s = 18;

std::string make_line(const StatusFacts& facts) {
    const preview::Progressive::Status& p = facts.picture;
    const int percent = static_cast<int>(p.share * 100);
    std::string out;
    if (p.step > 1)
        out = fmt::format("pass of {} px, {} %", p.step, percent);
    else if (p.samples == 0)
        out = fmt::format("first sample, {} %", percent);
    else
        out =
            fmt::format("{}{} of {} samples", facts.busy ? "" : "done, ", p.samples, p.of_samples);
    if (p.seconds > 0)
        out += fmt::format("   {:.2f} Mray/s", static_cast<double>(p.rays) / 1e6 / p.seconds);
    if (facts.frame_s > 0)
        out += fmt::format("   {:.0f} fps", 1 / facts.frame_s);
    if (p.holes > 0)
        out += fmt::format("   holes: {}", p.holes);
    if (facts.missing > 0)
        out += fmt::format("   boxes on their way: {}", facts.missing);
    return out;
}

}  // namespace

void draw_status(const preview::EditorState& editor_state, const StatusFacts& facts, float left_px,
                 float width_px) {
    const double shown_s =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - editor_state.noticed_at)
            .count();
    ImGui::SetNextWindowPos({left_px, 0});
    ImGui::SetNextWindowBgAlpha(0.6f);
    constexpr ImGuiWindowFlags kBare = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs |
                                       ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoNav |
                                       ImGuiWindowFlags_NoFocusOnAppearing;
    ImGui::Begin("##status", nullptr, kBare);
    ImGui::TextUnformatted(make_line(facts).c_str());
    if (!editor_state.notice.empty() &&
        shown_s < (editor_state.notice_is_bad ? kBadNotice_s : kNotice_s)) {
        const float font = ImGui::GetFontSize();
        const ImVec4 plain = ImGui::GetStyleColorVec4(ImGuiCol_Text);
        const ImVec4 bad =
            editor_state.light ? ImVec4{0.75f, 0.1f, 0, 1} : ImVec4{1, 0.5f, 0.35f, 1};
        ImGui::PushTextWrapPos(std::max(width_px - left_px - font * 2, font * 10));
        ImGui::PushStyleColor(ImGuiCol_Text, editor_state.notice_is_bad ? bad : plain);
        ImGui::TextUnformatted(editor_state.notice.c_str());
        ImGui::PopStyleColor();
        ImGui::PopTextWrapPos();
    }
    ImGui::End();
}

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
