#include "raytracer/preview/panels/widgets.hpp"

#include <imgui.h>
#include <spdlog/spdlog.h>

#include <array>
#include <map>
#include <vector>

namespace terravox::panels::widgets {

void tip(const std::string& text) {
    if (!ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled))
        return;
    ImGui::BeginTooltip();
    ImGui::PushTextWrapPos(ImGui::GetFontSize() * 28);
    ImGui::TextUnformatted(text.c_str());
    ImGui::PopTextWrapPos();
    ImGui::EndTooltip();
}

std::optional<widgets::Typed> text_input(const char* label, const std::string& now,
                                         std::size_t most, const char* hint) {
    struct Typing {
        std::vector<char> text;
        int frame = 0;  ///< in which it was seen last
    };
    // Of the field that is left, and the one that is typed into next, for a frame.
    static std::map<ImGuiID, Typing> typing;
    const int frame = ImGui::GetFrameCount();
    std::erase_if(typing, [frame](const auto& t) {
        return t.second.frame < frame - 1;
    });  // fields that have gone
    const ImGuiID id = ImGui::GetID(label);
    const auto known = typing.find(id);
    std::vector<char> text(most + 1);
    if (known != typing.end())
        text = known->second.text;
    else
        now.copy(text.data(), most);
    const bool entered = ImGui::InputTextWithHint(label, hint, text.data(), text.size(),
                                                  ImGuiInputTextFlags_EnterReturnsTrue);
    if (ImGui::IsItemActive())
        typing[id] = {text, frame};
    const bool left = ImGui::IsItemDeactivated() && known != typing.end();
    if (!entered && !left)
        return std::nullopt;
    typing.erase(id);
    // Escape takes back what was typed: ImGui has put the old text there.
    const std::string said = text.data();
    if (said == now && !entered)
        return std::nullopt;
    return widgets::Typed{said, entered};
}

bool reset_button(bool enabled) {
    ImGui::BeginDisabled(!enabled);
    const bool pressed = ImGui::Button("x", {ImGui::GetFrameHeight(), 0});
    widgets::tip("reset");
    ImGui::EndDisabled();
    return pressed;
}

void report_place(const std::string& name) {
    if (!spdlog::should_log(spdlog::level::trace))
        return;
    static std::map<std::string, std::array<float, 4>> reported;
    const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
    const std::array<float, 4> place{low.x, low.y, high.x, high.y};
    if (reported[name] == place)
        return;
    reported[name] = place;
    spdlog::trace("place of {}: {:.0f} {:.0f} {:.0f} {:.0f}", name, low.x, low.y, high.x, high.y);
}

bool button(const char* label, bool enabled) {
    ImGui::BeginDisabled(!enabled);
    const bool pressed = ImGui::Button(label);
    ImGui::EndDisabled();
    widgets::report_place(label);
    return pressed;
}

}  // namespace terravox::panels::widgets
