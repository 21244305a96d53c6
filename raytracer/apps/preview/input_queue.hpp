#pragma once

#include <deque>
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

}  // namespace terravox::preview
