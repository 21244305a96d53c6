#pragma once

#include <set>
#include <vector>

#include "raytracer/apps/preview/input_queue.hpp"

namespace terravox::preview {

/// The keys of a frame, by the numbers of GLFW, and their modifiers.
///
/// They are read from the events alone. Dear ImGui would answer otherwise from version to version:
/// since 1.87 keys have numbers of its own, which follow the layout of the keyboard, and since 1.89
/// its backend reads the modifiers as they are when it receives a key, so that a Ctrl+S that was
/// released before that frame would be an S. Not thread-safe.
class Keyboard {
public:
    /// @param events of the frame that begins, oldest first
    void begin_frame(const std::vector<InputEvent>& events);
    [[nodiscard]] bool down(int key) const { return m_down.contains(key); }
    /// Whether it went down in this frame.
    [[nodiscard]] bool pressed(int key) const { return m_pressed.contains(key); }
    /// Whether it went down in this frame, or the system repeats it because it is held.
    [[nodiscard]] bool repeated(int key) const { return pressed(key) || m_repeated.contains(key); }
    /// Modifiers that hold for the keys of this frame: those that the system gave with the last
    /// key, such as a Ctrl that sticks.
    [[nodiscard]] bool ctrl() const noexcept;
    [[nodiscard]] bool shift() const noexcept;
    [[nodiscard]] bool alt() const noexcept;
    [[nodiscard]] bool super() const noexcept;

private:
    void read(const KeyInput& key);
    std::set<int> m_down;
    std::set<int> m_pressed;
    std::set<int> m_repeated;
    int m_mods = 0;  ///< bits of GLFW
};

}  // namespace terravox::preview
