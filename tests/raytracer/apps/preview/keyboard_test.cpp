#include "raytracer/apps/preview/input_queue.hpp"

#include <GLFW/glfw3.h>

#include <string>

#include "tests/catch.hpp"

using namespace terravox;

namespace {

preview::KeyInput press(int key, int mods = 0) {
    return {key, 0, mods, true, false};
}
preview::KeyInput repeat(int key, int mods = 0) {
    return {key, 0, mods, true, true};
}
preview::KeyInput release(int key, int mods = 0) {
    return {key, 0, mods, false, false};
}

/// Its modifiers, a letter each.
std::string modifiers(const preview::Keyboard& keyboard) {
    std::string out;
    if (keyboard.ctrl())
        out += 'c';
    if (keyboard.shift())
        out += 's';
    if (keyboard.alt())
        out += 'a';
    if (keyboard.super())
        out += 'w';
    return out;
}

}  // namespace

TEST_CASE("a key goes down in one frame, and is down until it is released", "[preview][input]") {
    preview::Keyboard keyboard;
    struct Step {
        const char* name;
        std::vector<preview::InputEvent> events;
        bool pressed;
        bool repeated;
        bool down;
    };
    for (const Step& step : std::vector<Step>{
             {"nothing", {}, false, false, false},
             {"another key", {press(GLFW_KEY_A)}, false, false, false},
             {"it is pressed", {press(GLFW_KEY_S)}, true, true, true},
             {"held", {}, false, false, true},
             {"its repetition", {repeat(GLFW_KEY_S)}, false, true, true},
             {"no key", {preview::WheelInput{0, 1}}, false, false, true},
             {"another is released", {release(GLFW_KEY_A)}, false, false, true},
             {"it is released", {release(GLFW_KEY_S)}, false, false, false},
             {"pressed and released", {press(GLFW_KEY_S), release(GLFW_KEY_S)}, true, true, false},
         }) {
        INFO(step.name);
        keyboard.begin_frame(step.events);
        CHECK(keyboard.pressed(GLFW_KEY_S) == step.pressed);
        CHECK(keyboard.repeated(GLFW_KEY_S) == step.repeated);
        CHECK(keyboard.down(GLFW_KEY_S) == step.down);
    }
}

TEST_CASE("a command has the modifiers that were held when its key was pressed",
          "[preview][input]") {
    constexpr int kCtrl = GLFW_KEY_LEFT_CONTROL;
    constexpr int kOtherCtrl = GLFW_KEY_RIGHT_CONTROL;
    constexpr int kC = GLFW_MOD_CONTROL;
    struct Case {
        const char* name;
        std::vector<preview::InputEvent> events;
        const char* modifiers;
    };
    const auto c = GENERATE(values<Case>({
        {"none", {press(GLFW_KEY_S)}, ""},
        {"Ctrl alone, whose press X11 gives without it", {press(kCtrl)}, "c"},
        {"Ctrl and a key", {press(kCtrl), press(GLFW_KEY_S, kC)}, "c"},
        {"Ctrl that sticks: it was released before", {press(GLFW_KEY_S, kC)}, "c"},
        {"all four",
         {press(GLFW_KEY_S, GLFW_MOD_CONTROL | GLFW_MOD_SHIFT | GLFW_MOD_ALT | GLFW_MOD_SUPER)},
         "csaw"},
        {"Ctrl that is released, which X11 gives with it", {press(kCtrl), release(kCtrl, kC)}, ""},
        {"one of two is released", {press(kCtrl), press(kOtherCtrl, kC), release(kCtrl, kC)}, "c"},
        {"a click changes nothing", {press(kCtrl), preview::ButtonInput{0, true}}, "c"},
        {"the window lost the keys: they are released without modifiers",
         {press(kCtrl), press(GLFW_KEY_S, kC), release(GLFW_KEY_S), release(kCtrl)},
         ""},
    }));
    DYNAMIC_SECTION(c.name) {
        // However the events fall into frames.
        const bool at_once = GENERATE(true, false);
        preview::Keyboard keyboard;
        if (at_once)
            keyboard.begin_frame(c.events);
        for (std::size_t i = 0; !at_once && i < c.events.size(); ++i)
            keyboard.begin_frame({c.events[i]});
        CHECK(modifiers(keyboard) == c.modifiers);
    }
}
