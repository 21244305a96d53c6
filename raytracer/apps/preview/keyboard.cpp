#include "raytracer/apps/preview/keyboard.hpp"

#include <GLFW/glfw3.h>

namespace terravox::preview {
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
