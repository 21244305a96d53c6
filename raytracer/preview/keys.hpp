#pragma once

#include <imgui.h>

namespace terravox::preview {

// Keys by the numbers of GLFW. Dear ImGui 1.86 takes those of the window library; versions 1.87 to
// 1.91 have numbers of their own in a type of their own, and still take the others.

[[nodiscard]] inline bool is_key_down(int key) {
    return ImGui::IsKeyDown(static_cast<ImGuiKey>(key));
}
/// Whether it went down in this frame.
/// @param repeats also each time that the system repeats it while it is held
[[nodiscard]] inline bool is_key_pressed(int key, bool repeats) {
    return ImGui::IsKeyPressed(static_cast<ImGuiKey>(key), repeats);
}

}  // namespace terravox::preview
