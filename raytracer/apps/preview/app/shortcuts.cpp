#include "raytracer/apps/preview/app/app.hpp"

#include <GLFW/glfw3.h>
#include <imgui.h>

#include <algorithm>

namespace terravox::preview {
namespace {

/// Shortcuts with Ctrl.
void handle_commands(const ShortcutTargets& on, const Keyboard& keys) {
    if (keys.pressed(Window::to_key('q')))
        on.window.close();
    if (Window::typing())
        return;
    if (keys.pressed(Window::to_key('s')))
        on.files.save_scene(on.editor_state);
    if (keys.pressed(Window::to_key('o')))
        on.files.open_scene(on.editor_state);
    if (keys.pressed(Window::to_key('p')))
        on.files.save_picture(on.editor_state, on.picture);
    if (keys.pressed(Window::to_key('r')))
        on.files.start_final(on.editor_state, on.final_render);
    if (keys.pressed(Window::to_key('k'))) {
        on.window.copy_text(on.files.command_line(on.editor_state));
        on.editor_state.notify("the command line is on the clipboard");
    }
    if (keys.repeated(Window::to_key('z')) && !keys.shift())
        on.editor_state.undo();
    if (keys.repeated(Window::to_key('y')) || (keys.repeated(Window::to_key('z')) && keys.shift()))
        on.editor_state.redo();
}

/// Shortcuts that show and hide parts of the window; they also work while a text field takes the
/// letters.
void handle_view_keys(EditorState& state, const Keyboard& keys) {
    if (keys.pressed(GLFW_KEY_F1))
        state.shows_help = !state.shows_help;
    if (keys.pressed(GLFW_KEY_F2))
        state.shows_panel = !state.shows_panel;
    if (keys.pressed(GLFW_KEY_F3))
        state.shows_map = !state.shows_map;
    if (keys.pressed(GLFW_KEY_F4))
        state.shows_path = !state.shows_path;
    const auto skip_layers = [&state](std::size_t count) {
        const auto at = static_cast<std::size_t>(state.layer);
        state.layer = kLayers[(at + count) % kLayers.size()].layer;
    };
    if (keys.pressed(GLFW_KEY_F5))
        skip_layers(kLayers.size() - 1);
    if (keys.pressed(GLFW_KEY_F6))
        skip_layers(1);
    if (keys.pressed(GLFW_KEY_F7))
        state.light = !state.light;
    if (keys.pressed(GLFW_KEY_F8))
        state.fills = !state.fills;
}

void handle_tool_keys(const ShortcutTargets& on, const Keyboard& keys) {
    EditorState& state = on.editor_state;
    if (keys.pressed(GLFW_KEY_ESCAPE)) {
        on.pick.clear();
        state.shows_help = false;
        ImGui::SetWindowFocus(nullptr);
    }
    if (keys.pressed(Window::to_key('f'))) {
        state.fly = !state.fly;
        state.notify(state.fly ? "fly: the mouse turns your head"
                               : "orbit: the mouse circles what you look at");
    }
    if (keys.pressed(Window::to_key('m'))) {
        state.measures = !state.measures;
        on.pick.clear();
    }
    if (keys.pressed(Window::to_key('v'))) {
        const Navigator::Click middle{on.pane.x + on.pane.width / 2.0,
                                      on.pane.y + on.pane.height / 2.0, false};
        on.pick.click(state, middle, on.pane, on.picture.view());
    }
    if (keys.pressed(Window::to_key('k'))) {
        on.path.add_key(state);
        state.shows_path = true;
    }
    if (keys.pressed(Window::to_key('p')))
        on.path.toggle(state);
    if (keys.pressed(GLFW_KEY_HOME) && !ImGui::GetIO().NavActive)
        state.frame_all();
}

void handle_scene_keys(scene::Scene& scene, const Keyboard& keys) {
    constexpr double kQuarter_h = 0.25;
    constexpr double kThird_ev = 1.0 / 3;
    double& time_h = scene.sun.time_h;
    if (keys.repeated(GLFW_KEY_LEFT_BRACKET))
        time_h = std::max(time_h - kQuarter_h, 0.0);
    if (keys.repeated(GLFW_KEY_RIGHT_BRACKET))
        time_h = std::min(time_h + kQuarter_h, 24.0);
    double& exposure_ev = scene.output.exposure_ev;
    if (keys.repeated(GLFW_KEY_MINUS))
        exposure_ev = std::max(exposure_ev - kThird_ev, -20.0);
    if (keys.repeated(GLFW_KEY_EQUAL))
        exposure_ev = std::min(exposure_ev + kThird_ev, 20.0);
}

}  // namespace

void handle_shortcuts(const ShortcutTargets& on) {
    const Keyboard& keys = on.window.keyboard();
    if (keys.ctrl())
        return handle_commands(on, keys);
    handle_view_keys(on.editor_state, keys);
    if (Window::typing())
        return;
    handle_tool_keys(on, keys);
    handle_scene_keys(on.editor_state.scene, keys);
}

}  // namespace terravox::preview
