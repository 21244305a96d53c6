#pragma once

#include <array>
#include <optional>
#include <set>

#include "raytracer/preview/editor_state.hpp"
#include "raytracer/preview/window.hpp"

namespace terravox::preview {

/// Moves the viewpoint by mouse, keys and gamepad, and tells clicks from drags. Positions: pixels
/// of the window.
class Navigator {
public:
    /// After ImGui has begun the frame. @param seconds since the last @return the viewpoint has
    /// moved
    bool handle(EditorState& editor_state, const Gamepad& pad, double seconds);

    struct Click {
        double x = 0, y = 0;
        bool twice = false;
    };
    /// On the picture, without a drag, since the last handle().
    [[nodiscard]] const std::optional<Click>& click() const noexcept { return m_click; }
    /// A key or button is held that moves.
    [[nodiscard]] bool moving() const noexcept { return m_moving; }

private:
    bool drag(EditorState& editor_state);
    bool keys(EditorState& editor_state, double seconds);
    bool pad(EditorState& editor_state, const Gamepad& pad, double seconds);
    [[nodiscard]] double reach(const EditorState& editor_state) const noexcept;
    bool closer(EditorState& editor_state, double factor);

    std::optional<Click> m_click;
    std::set<int> m_commands;  ///< keys that are down for something else
    std::array<float, 2> m_pressed_at{};
    bool m_pressed = false, m_dragged = false, m_moving = false;
};

}  // namespace terravox::preview
