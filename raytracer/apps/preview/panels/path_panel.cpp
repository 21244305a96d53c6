#include "raytracer/apps/preview/panels/panels.hpp"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "raytracer/apps/preview/panels/form.hpp"

namespace terravox::panels {

std::optional<animate::Animation> PathPanel::make(preview::EditorState& editor_state) const {
    try {
        return m_path.animation(editor_state.scene);
    } catch (const util::Error& e) {
        editor_state.notify(e.what(), true);
        return std::nullopt;
    }
}

void PathPanel::add_key(preview::EditorState& editor_state) {
    m_chosen = m_path.put(m_time_s, editor_state.placed());
    editor_state.notify(fmt::format("key frame at {:.2f} s", m_time_s));
    // The next key is usually a later one.
    constexpr double kNext_s = 3;
    m_time_s += kNext_s;
    m_length_s = std::max(m_length_s, m_time_s);
}

void PathPanel::toggle(preview::EditorState& editor_state) {
    if (playing()) {
        m_animation.reset();
        return;
    }
    if (m_path.keys().empty())
        return editor_state.notify("play the flight: it has no key frames", true);
    if (m_time_s >= m_path.seconds())
        m_time_s = 0;
    m_animation = make(editor_state);
    m_before = editor_state.placed();
    editor_state.history.note(editor_state.scene);
    m_began = std::chrono::steady_clock::now();
    m_began_s = m_time_s;
}

void PathPanel::play(preview::EditorState& editor_state, bool ready) {
    if (!playing())
        return;
    m_time_s = m_began_s +
               std::chrono::duration<double>(std::chrono::steady_clock::now() - m_began).count();
    if (m_time_s >= m_path.seconds())
        m_time_s = m_path.seconds();
    if (!ready && m_time_s < m_path.seconds())
        return;
    const int frame = std::clamp(static_cast<int>(std::lround(m_time_s * m_animation->fps())), 0,
                                 m_animation->frames() - 1);
    try {
        editor_state.show(m_animation->at(frame, m_before));
    } catch (const util::Error& e) {
        editor_state.notify(e.what(), true);
        m_animation.reset();
    }
    if (m_time_s >= m_path.seconds())
        m_animation.reset();
}

void PathPanel::show(preview::EditorState& editor_state, double time_s) {
    m_time_s = std::max(time_s, 0.0);
    if (m_path.keys().empty())
        return;
    editor_state.attempt([&] {
        const animate::Animation animation = m_path.animation(editor_state.scene);
        editor_state.show(
            animation.at(std::clamp(static_cast<int>(std::lround(m_time_s * animation.fps())), 0,
                                    animation.frames() - 1),
                         editor_state.placed()));
    });
}

void PathPanel::save(preview::EditorState& editor_state) {
    editor_state.attempt([&] {
        (void)m_path.animation(editor_state.scene);
        util::write_file_atomically(m_file, m_path.to_toml(editor_state.scene));
        editor_state.notify("saved " + m_file + "; terravox animate " + m_file +
                            " WORLD makes pictures of it");
    });
}

// Keys are diamonds on a line, which can be dragged; a click between them moves the time there.
void PathPanel::draw_line(preview::EditorState& editor_state) {
    const float font = ImGui::GetFontSize();
    const float width = ImGui::GetContentRegionAvail().x;
    const float height = font * 2;
    const ImVec2 low = ImGui::GetCursorScreenPos();
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const float left = low.x + font;
    const float span = width - 2 * font;
    const float middle = low.y + height / 2;
    const auto find_x = [&](double s) { return left + static_cast<float>(s / m_length_s) * span; };
    const auto to_time = [&](float x) {
        return std::clamp(static_cast<double>((x - left) / span), 0.0, 1.0) * m_length_s;
    };
    const ImU32 line = ImGui::GetColorU32(ImGuiCol_TextDisabled);
    const ImU32 key_colour = ImGui::GetColorU32(ImGuiCol_PlotHistogram);
    const ImU32 now = ImGui::GetColorU32(ImGuiCol_Text);
    ImGui::InvisibleButton("##line", {width, height});
    widgets::report_place("time line");
    const bool pressed = ImGui::IsItemActivated();
    const bool held = ImGui::IsItemActive();
    const float mouse = ImGui::GetIO().MousePos.x;
    if (pressed && ImGui::IsMouseDown(ImGuiMouseButton_Left)) {
        m_chosen.reset();
        for (std::size_t i = 0; i < m_path.keys().size(); ++i)
            if (std::abs(find_x(m_path.keys()[i].time_s) - mouse) < font * 0.6f)
                m_chosen = i;
    }
    const bool by_mouse = held && ImGui::IsMouseDown(ImGuiMouseButton_Left);
    if (by_mouse && m_chosen && ImGui::IsMouseDragging(ImGuiMouseButton_Left))
        m_path.move(*m_chosen, to_time(mouse));
    else if (by_mouse)
        show(editor_state, m_chosen ? m_path.keys()[*m_chosen].time_s : to_time(mouse));
    list.AddLine({left, middle}, {left + span, middle}, line, 2);
    const double every_s = m_length_s > 60 ? 10 : m_length_s > 20 ? 5 : 1;
    for (double s = 0; s <= m_length_s + 1e-6; s += every_s)
        list.AddLine({find_x(s), middle - font / 4}, {find_x(s), middle + font / 4}, line);
    for (std::size_t i = 0; i < m_path.keys().size(); ++i) {
        const ImVec2 at{find_x(m_path.keys()[i].time_s), middle};
        const float r = font * 0.45f;
        list.AddQuadFilled({at.x - r, at.y}, {at.x, at.y - r}, {at.x + r, at.y}, {at.x, at.y + r},
                           key_colour);
        if (m_chosen == i)
            list.AddQuad({at.x - r, at.y}, {at.x, at.y - r}, {at.x + r, at.y}, {at.x, at.y + r},
                         now, 2);
    }
    list.AddLine({find_x(m_time_s), low.y}, {find_x(m_time_s), low.y + height}, now, 2);
}

float PathPanel::draw(preview::EditorState& editor_state, float panel_px,
                      std::array<int, 2> window_px) {
    if (!editor_state.shows_path)
        return 0;
    const float font = ImGui::GetFontSize();
    const float left = panel_px + font;
    ImGui::SetNextWindowPos({left, static_cast<float>(window_px[1]) - font}, ImGuiCond_Always,
                            {0, 1});
    ImGui::SetNextWindowSize(
        {std::max(static_cast<float>(window_px[0]) - left - font, font * 20), 0});
    ImGui::Begin(
        "Flight", &editor_state.shows_path,
        ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoFocusOnAppearing);
    if (widgets::button("Add key (K)"))
        add_key(editor_state);
    ImGui::SameLine();
    if (widgets::button(playing() ? "Stop (P)" : "Play (P)"))
        toggle(editor_state);
    ImGui::SameLine();
    if (widgets::button("Remove key", m_chosen.has_value())) {
        m_path.remove(*m_chosen);
        m_chosen.reset();
    }
    ImGui::SameLine();
    ImGui::Checkbox("ease", &m_path.ease);
    widgets::tip("it begins and ends at rest");
    ImGui::SameLine();
    ImGui::SetNextItemWidth(font * 6);
    auto fps = static_cast<float>(m_path.fps);
    if (ImGui::DragFloat("##fps", &fps, 0.1f, 1, 120, "%.0f fps"))
        m_path.fps = std::clamp(static_cast<double>(fps), 1.0, 120.0);
    ImGui::SameLine();
    ImGui::SetNextItemWidth(font * 6);
    auto length = static_cast<float>(m_length_s);
    if (ImGui::DragFloat("##length", &length, 0.1f, 1, 3600, "%.1f s"))
        m_length_s =
            std::clamp(static_cast<double>(length), std::max(1.0, m_path.seconds()), 3600.0);
    widgets::tip("how much time the line shows");
    draw_line(editor_state);
    ImGui::Text("%.2f s", m_time_s);
    ImGui::SameLine();
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x - font * 8);
    if (const auto typed = widgets::text_input("##flight file", m_file, 1000, "file"))
        m_file = typed->text;
    ImGui::SameLine();
    if (widgets::button("Save flight", !m_path.keys().empty()))
        save(editor_state);
    const float height = ImGui::GetWindowHeight();
    ImGui::End();
    return height;
}

}  // namespace terravox::panels
