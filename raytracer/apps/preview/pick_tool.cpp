#include "raytracer/apps/preview/pick_tool.hpp"
#include "common/util/log.hpp"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace terravox::preview {
namespace {

std::string metres(double m) {
    std::array<char, 40> out{};
    std::snprintf(out.data(), out.size(), "%.2f m", m);
    return out.data();
}

void draw_row(const std::string& name, const std::string& value) {
    ImGui::TextDisabled("%s", name.c_str());
    ImGui::SameLine(ImGui::GetFontSize() * 8);
    ImGui::TextWrapped("%s", value.c_str());
}

}  // namespace

Measured measure(const Picked& from, const Picked& to, double voxel_m) noexcept {
    const core::Vec3 way = (to.point - from.point) * voxel_m;
    Measured out;
    out.level_m = std::hypot(way.x, way.z);
    out.height_m = way.y;
    out.length_m = core::length(way);
    out.heading_deg = std::atan2(way.x, -way.z) * 180 / std::numbers::pi;
    if (out.heading_deg < 0)
        out.heading_deg += 360;
    return out;
}

std::optional<core::Ray> ray_through(const scene::Camera& camera, std::array<int, 2> picture_px,
                                     const Pane& pane, double x, double y) noexcept {
    if (!pane.holds(x, y))
        return std::nullopt;
    const double px = (x - pane.x) / pane.width * picture_px[0];
    const double py = (y - pane.y) / pane.height * picture_px[1];
    return camera.ray(px, py, 0.5, 0.5);
}

void PickTool::click(const EditorState& editor_state, const Navigator::Click& click,
                     const Pane& pane, const std::shared_ptr<const shade::View>& view) {
    if (!view)
        return;
    const auto ray = ray_through(view->camera, view->scene.output.size_px, pane, click.x, click.y);
    if (!ray)
        return;
    Picker::Use use = editor_state.measures ? Picker::Use::kMeasure : Picker::Use::kRead;
    if (click.twice)
        use = Picker::Use::kFocus;
    m_picker.ask(use, view, *ray);
}

void PickTool::go(const EditorState& editor_state, double x, double z,
                  const std::shared_ptr<const shade::View>& view) {
    m_go = {x, editor_state.viewpoint.target.y, z};
    m_picker.ask(Picker::Use::kGo, view, plumb_line(editor_state.info(), x, z));
}

bool PickTool::update(EditorState& editor_state) {
    const auto answer = m_picker.take();
    if (!answer)
        return false;
    using Use = Picker::Use;
    const auto& picked = answer->picked;
    switch (answer->use) {
        case Use::kRead:
            m_read = picked;
            if (!picked) {
                editor_state.notify("nothing there: the ray leaves the world");
                return false;
            }
            m_facts = facts_of(*picked, editor_state.info());
            for (const PickedFact& fact : m_facts)
                util::log_debug("picked {}: {}", fact.name, fact.value);
            return false;
        case Use::kMeasure:
            if (!picked)
                editor_state.notify("nothing there to measure: the ray leaves the world");
            else if (!m_first || m_second) {
                m_first = picked;
                m_second.reset();
            } else
                m_second = picked;
            if (m_second) {
                const Measured m = measure(*m_first, *m_second, editor_state.info().voxel_m);
                util::log_debug("measured {:.2f} m on the map, {:.2f} m up, {:.2f} m in all",
                                m.level_m, m.height_m, m.length_m);
            }
            return false;
        case Use::kFocus:
            if (!picked)
                return false;
            editor_state.viewpoint.face(picked->point);
            break;
        case Use::kGo: editor_state.viewpoint.go_to(picked ? picked->point : m_go); break;
    }
    editor_state.moved();
    return true;
}

void PickTool::draw_marks(const shade::View& view, const Pane& pane) const {
    constexpr ImU32 kDark = IM_COL32(0, 0, 0, 200);
    constexpr ImU32 kReading = IM_COL32(90, 220, 255, 255);
    constexpr ImU32 kMeasuring = IM_COL32(255, 210, 60, 255);
    ImDrawList& above = *ImGui::GetBackgroundDrawList();
    above.PushClipRect(
        {static_cast<float>(pane.x), static_cast<float>(pane.y)},
        {static_cast<float>(pane.x + pane.width), static_cast<float>(pane.y + pane.height)});
    const auto place_of = [&](const std::optional<Picked>& p) -> std::optional<ImVec2> {
        const auto at = p ? pixel_of(view.camera, p->point, pane.width, pane.height) : std::nullopt;
        if (!at)
            return std::nullopt;
        return ImVec2{static_cast<float>(pane.x + (*at)[0]), static_cast<float>(pane.y + (*at)[1])};
    };
    const auto from = place_of(m_first);
    const auto to = place_of(m_second);
    if (from && to) {
        above.AddLine(*from, *to, kDark, 4);
        above.AddLine(*from, *to, kMeasuring, 2);
    }
    const auto mark = [&](const std::optional<ImVec2>& at, ImU32 colour) {
        if (at) {
            above.AddCircle(*at, 6, kDark, 0, 4);
            above.AddCircle(*at, 6, colour, 0, 2);
        }
    };
    mark(place_of(m_read), kReading);
    mark(from, kMeasuring);
    mark(to, kMeasuring);
    above.PopClipRect();
}

void PickTool::draw_distance(const voxel::WorldInfo& world) const {
    if (m_first && m_second) {
        const Measured m = measure(*m_first, *m_second, world.voxel_m);
        draw_row("on the map", metres(m.level_m));
        draw_row("height", metres(m.height_m));
        draw_row("in all", metres(m.length_m));
        draw_row("towards", std::to_string(std::lround(m.heading_deg)) + "\u00b0");
    } else if (m_first) {
        ImGui::TextUnformatted("click on the other end");
    }
}

void PickTool::draw_facts(EditorState& editor_state) const {
    const float font = ImGui::GetFontSize();
    std::string all;
    for (const PickedFact& fact : m_facts) {
        draw_row(fact.name, fact.value);
        all += fact.name + ": " + fact.value + "\n";
    }
    if (m_read->attr.has_colour() && !m_read->hole) {
        const voxel::Rgb8 c = m_read->attr.colour;
        ImGui::SameLine();
        ImGui::ColorButton("##colour", {c.r / 255.0f, c.g / 255.0f, c.b / 255.0f, 1},
                           ImGuiColorEditFlags_NoTooltip, {font, font});
    }
    if (ImGui::Button("Copy"))
        ImGui::SetClipboardText(all.c_str());
    ImGui::SameLine();
    if (ImGui::Button("Look at it")) {
        editor_state.viewpoint.face(m_read->point);
        editor_state.moved();
    }
    ImGui::SameLine();
    if (ImGui::Button("Focus lens"))
        editor_state.scene.camera.focus_m = std::clamp(m_read->distance_m, 0.001, 1e7);
}

void PickTool::draw(EditorState& editor_state, const shade::View& view, const Pane& pane,
                    std::array<int, 2> window_px) {
    draw_marks(view, pane);
    if (!m_read && !m_first && !m_picker.busy())
        return;
    const float font = ImGui::GetFontSize();
    ImGui::SetNextWindowPos({static_cast<float>(window_px[0]) - font, font * 3}, ImGuiCond_Always,
                            {1, 0});
    ImGui::SetNextWindowSize({font * 26, 0});
    bool open = true;
    ImGui::Begin(editor_state.measures ? "Distance" : "Voxel", &open,
                 ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav |
                     ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize);
    if (m_picker.busy())
        ImGui::TextDisabled("looking it up ...");
    if (editor_state.measures)
        draw_distance(editor_state.info());
    else if (m_read)
        draw_facts(editor_state);
    ImGui::End();
    if (!open)
        clear();
}

}  // namespace terravox::preview
