#include "raytracer/apps/preview/panels/widgets.hpp"
#include "common/util/log.hpp"

#include <imgui.h>

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
                                         std::size_t max_bytes, const char* hint) {
    struct Typing {
        std::vector<char> text;
        int frame = 0;  ///< the last frame that drew it
    };
    // For one frame there are two states: of the field that loses the focus, and of the one that
    // gets it.
    static std::map<ImGuiID, Typing> typing;
    const int frame = ImGui::GetFrameCount();
    std::erase_if(typing, [frame](const auto& t) {
        return t.second.frame < frame - 1;
    });  // fields that are not drawn any more
    const ImGuiID id = ImGui::GetID(label);
    const auto known = typing.find(id);
    std::vector<char> text(max_bytes + 1);
    if (known != typing.end())
        text = known->second.text;
    else
        now.copy(text.data(), max_bytes);
    const bool entered = ImGui::InputTextWithHint(label, hint, text.data(), text.size(),
                                                  ImGuiInputTextFlags_EnterReturnsTrue);
    if (ImGui::IsItemActive())
        typing[id] = {text, frame};
    const bool left = ImGui::IsItemDeactivated() && known != typing.end();
    if (!entered && !left)
        return std::nullopt;
    typing.erase(id);
    // Escape reverts the input: ImGui has restored the old text.
    const std::string typed = text.data();
    if (typed == now && !entered)
        return std::nullopt;
    return widgets::Typed{typed, entered};
}

bool reset_button(bool enabled) {
    ImGui::BeginDisabled(!enabled);
    const bool pressed = ImGui::Button("x", {ImGui::GetFrameHeight(), 0});
    widgets::tip("reset");
    ImGui::EndDisabled();
    return pressed;
}

void report_place(const std::string& name) {
    if (!util::is_logged(util::LogLevel::kTrace))
        return;
    static std::map<std::string, std::array<float, 4>> reported;
    const ImVec2 low = ImGui::GetItemRectMin();
    const ImVec2 high = ImGui::GetItemRectMax();
    const std::array<float, 4> place{low.x, low.y, high.x, high.y};
    if (reported[name] == place)
        return;
    reported[name] = place;
    util::log_trace("place of {}: {:.0f} {:.0f} {:.0f} {:.0f}", name, low.x, low.y, high.x, high.y);
}

bool button(const char* label, bool enabled) {
    ImGui::BeginDisabled(!enabled);
    const bool pressed = ImGui::Button(label);
    ImGui::EndDisabled();
    widgets::report_place(label);
    return pressed;
}

}  // namespace terravox::panels::widgets
