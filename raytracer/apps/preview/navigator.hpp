#pragma once

#include <array>
#include <optional>
#include <set>

#include "raytracer/apps/preview/editor_state.hpp"
#include "raytracer/apps/preview/window.hpp"

namespace terravox::preview {

/// Moves the viewpoint by mouse and keys, and distinguishes clicks from drags. Positions
/// are in pixels of the window.
class Navigator {
public:
    /// Handles the input of a frame, after Dear ImGui has begun it.
    /// @param seconds since the last frame
    /// @return whether the viewpoint has moved
    bool handle(EditorState& editor_state, const Keyboard& keyboard, double seconds);

    struct Click {
        double x = 0;
        double y = 0;
        bool twice = false;
    };
    /// The click on the picture since the last handle(), if there was one.
    [[nodiscard]] const std::optional<Click>& click() const noexcept { return m_click; }
    /// Whether a key or button that moves the viewpoint is held.
    [[nodiscard]] bool moving() const noexcept { return m_moving; }

private:
    bool drag(EditorState& editor_state);
    bool keys(EditorState& editor_state, const Keyboard& keyboard, double seconds);
    [[nodiscard]] double reach(const EditorState& editor_state) const noexcept;
    bool closer(EditorState& editor_state, double factor);

    std::optional<Click> m_click;
    std::set<int> m_commands;  ///< keys that are down for something other than movement
    std::array<float, 2> m_pressed_at{};
    double m_pace = 1;  ///< of movement: faster with Shift, slower with Alt
    bool m_pressed = false;
    bool m_dragged = false;
    bool m_moving = false;
};

}  // namespace terravox::preview
