#include "raytracer/apps/preview/input_queue.hpp"

#include <GLFW/glfw3.h>
#include <algorithm>

namespace terravox::preview {
namespace {

template <typename Input>
bool is(const InputEvent& event) {
    return std::holds_alternative<Input>(event);
}

/// The kind of frame that an event ends.
enum class Ending { kNone, kPress, kRelease, kCharacters, kButton, kWheel, kDrag };

Ending find_ending(const InputEvent& event, bool dragging) {
    if (const auto* key = std::get_if<KeyInput>(&event))
        return key->down ? Ending::kPress : Ending::kRelease;
    if (is<CharacterInput>(event))
        return Ending::kCharacters;
    if (is<ButtonInput>(event))
        return Ending::kButton;
    if (is<WheelInput>(event))
        return Ending::kWheel;
    return dragging ? Ending::kDrag : Ending::kNone;
}

/// Whether an event may still be added to a frame that another one has ended.
bool may_follow(Ending ended, Ending next) {
    switch (ended) {
        case Ending::kNone: return true;
        case Ending::kPress:  // the window system sends the characters of a key right after its
                              // press
        case Ending::kCharacters: return next == Ending::kCharacters;
        case Ending::kRelease:
            return next == Ending::kRelease;  // of Ctrl+Tab: another window has the keys then
        case Ending::kWheel: return next == Ending::kWheel;
        case Ending::kDrag: return next == Ending::kDrag;
        case Ending::kButton: return false;
    }
    return false;
}

/// Dear ImGui would not notice a key that is released and pressed again within one frame.
bool changes_again(const InputEvent& event, const std::vector<InputEvent>& frame) {
    const auto* key = std::get_if<KeyInput>(&event);
    return key != nullptr &&
           std::any_of(frame.begin(), frame.end(), [&](const InputEvent& earlier) {
               const auto* other = std::get_if<KeyInput>(&earlier);
               return other != nullptr && other->key == key->key;
           });
}

}  // namespace

void InputQueue::push(const InputEvent& event) {
    const auto* key = std::get_if<KeyInput>(&event);
    if (key == nullptr || !key->repeats || m_events.empty())
        m_events.push_back(event);
}

std::vector<InputEvent> InputQueue::next_frame() {
    std::vector<InputEvent> frame;
    Ending ended = Ending::kNone;
    for (; !m_events.empty(); m_events.pop_front()) {
        const InputEvent& event = m_events.front();
        const Ending next = find_ending(event, m_buttons_down > 0);
        if (!may_follow(ended, next) || changes_again(event, frame))
            break;
        ended = next;
        if (const auto* button = std::get_if<ButtonInput>(&event))
            m_buttons_down = std::max(m_buttons_down + (button->down ? 1 : -1), 0);
        if (is<CursorInput>(event) && !frame.empty() && is<CursorInput>(frame.back()))
            frame.back() = event;
        else
            frame.push_back(event);
    }
    return frame;
}

namespace {

struct Modifier {
    int bit;
    int left;
    int right;
};
constexpr Modifier kModifiers[] = {
    {GLFW_MOD_CONTROL, GLFW_KEY_LEFT_CONTROL, GLFW_KEY_RIGHT_CONTROL},
    {GLFW_MOD_SHIFT, GLFW_KEY_LEFT_SHIFT, GLFW_KEY_RIGHT_SHIFT},
    {GLFW_MOD_ALT, GLFW_KEY_LEFT_ALT, GLFW_KEY_RIGHT_ALT},
    {GLFW_MOD_SUPER, GLFW_KEY_LEFT_SUPER, GLFW_KEY_RIGHT_SUPER}};

}  // namespace

void Keyboard::read(const KeyInput& key) {
    if (!key.down) {
        m_down.erase(key.key);
    } else {
        m_down.insert(key.key);
        (key.repeats ? m_repeated : m_pressed).insert(key.key);
    }
    m_mods = key.mods;
    // X11 gives the modifiers from before the event, which is wrong for a modifier's own key.
    for (const Modifier& modifier : kModifiers)
        if (key.key == modifier.left || key.key == modifier.right)
            m_mods = down(modifier.left) || down(modifier.right) ? m_mods | modifier.bit
                                                                 : m_mods & ~modifier.bit;
}

void Keyboard::begin_frame(const std::vector<InputEvent>& events) {
    m_pressed.clear();
    m_repeated.clear();
    for (const InputEvent& event : events)
        if (const auto* key = std::get_if<KeyInput>(&event))
            read(*key);
}

bool Keyboard::ctrl() const noexcept {
    return (m_mods & GLFW_MOD_CONTROL) != 0;
}
bool Keyboard::shift() const noexcept {
    return (m_mods & GLFW_MOD_SHIFT) != 0;
}
bool Keyboard::alt() const noexcept {
    return (m_mods & GLFW_MOD_ALT) != 0;
}
bool Keyboard::super() const noexcept {
    return (m_mods & GLFW_MOD_SUPER) != 0;
}

}  // namespace terravox::preview
