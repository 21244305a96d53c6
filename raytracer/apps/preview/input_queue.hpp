#pragma once

#include <deque>
#include <set>
#include <variant>
#include <vector>

namespace terravox::preview {

/// Key and button numbers are those of the window system; the queue only compares them.
struct KeyInput {
    int key = 0;
    int scancode = 0;
    int mods = 0;
    bool down = false;
    bool repeats = false;  ///< it went down before, and is held
    bool operator==(const KeyInput&) const = default;
};
struct CharacterInput {
    unsigned code_point = 0;  ///< Unicode
    bool operator==(const CharacterInput&) const = default;
};
/// Position of the mouse, pixels of the window.
struct CursorInput {
    double x = 0;
    double y = 0;
    bool operator==(const CursorInput&) const = default;
};
struct ButtonInput {
    int button = 0;
    bool down = false;
    bool operator==(const ButtonInput&) const = default;
};
struct WheelInput {
    double x = 0;
    double y = 0;
    bool operator==(const WheelInput&) const = default;
};
using InputEvent = std::variant<KeyInput, CharacterInput, CursorInput, ButtonInput, WheelInput>;

/// Input events in the order in which they happened, split into frames.
///
/// Dear ImGui reads the state of keys and buttons once a frame, and a widget that is clicked in one
/// frame takes keys from the next frame on. On a slow machine a click and the keys after it
/// arrive within one frame; read at once, the keys would go to whatever had the focus before the
/// click, and a key that is pressed and released would not be seen at all. So a frame ends after
/// each event that can change where the following events belong: a key press with its characters,
/// releases of keys, a button that changes, a turn of the wheel, a drag. Not thread-safe: callbacks
/// and frames are on the window's thread.
class InputQueue {
public:
    /// The repetition of a key is dropped while other events wait: frames that are slower than it
    /// would go on with it after the key was released.
    void push(const InputEvent& event);
    [[nodiscard]] bool empty() const noexcept { return m_events.empty(); }
    /// @return the events of the next frame, oldest first: not empty unless the queue is; of a run
    /// of cursor positions the last only
    [[nodiscard]] std::vector<InputEvent> next_frame();

private:
    std::deque<InputEvent> m_events;
    int m_buttons_down = 0;  ///< at the end of the last frame
};

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
