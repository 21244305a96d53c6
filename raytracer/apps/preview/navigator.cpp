#include "raytracer/apps/preview/navigator.hpp"

#include <GLFW/glfw3.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

namespace terravox::preview {
namespace {

constexpr double kDegreesPerPixel = 0.25;
constexpr double kDegreesPerSecond = 45;
constexpr float kDrag_px = 4;            // a shorter drag is a click
constexpr double kReachPerSecond = 0.9;  // of the distance to the target
constexpr double kFast = 4;
constexpr double kSlow = 0.25;
constexpr std::array kMoving{GLFW_KEY_A,  GLFW_KEY_D,    GLFW_KEY_S,       GLFW_KEY_W,
                             GLFW_KEY_Q,  GLFW_KEY_E,    GLFW_KEY_LEFT,    GLFW_KEY_RIGHT,
                             GLFW_KEY_UP, GLFW_KEY_DOWN, GLFW_KEY_PAGE_UP, GLFW_KEY_PAGE_DOWN};

bool parallel(const scene::Scene& scene) {
    return core::is_parallel(scene.camera.projection);
}

}  // namespace

bool Navigator::handle(EditorState& editor_state, const Keyboard& keyboard, double seconds) {
    m_click.reset();
    m_moving = false;
    const Viewpoint before = editor_state.viewpoint;
    const std::optional<double> height = editor_state.scene.camera.height_m;
    m_pace = keyboard.shift() ? kFast : keyboard.alt() ? kSlow : 1;
    bool moved = drag(editor_state);
    moved |= keys(editor_state, keyboard, seconds);
    if (!moved ||
        (before == editor_state.viewpoint && height == editor_state.scene.camera.height_m))
        return false;
    editor_state.moved();
    return true;
}

// Speed of movement, voxels per second.
double Navigator::reach(const EditorState& editor_state) const noexcept {
    return editor_state.viewpoint.distance() * kReachPerSecond * m_pace;
}

bool Navigator::closer(EditorState& editor_state, double factor) {
    // For parallel rays the height of the picture's area replaces the distance.
    if (parallel(editor_state.scene)) {
        const scene::Camera camera = scene::make_camera(editor_state.scene, editor_state.info(),
                                                        editor_state.info().camera_bounds());
        const double height_m = editor_state.scene.camera.height_m.value_or(
            camera.pixel_voxels(0) * editor_state.scene.output.size_px[1] *
            editor_state.info().voxel_m);
        editor_state.scene.camera.height_m = std::clamp(height_m * factor, 0.1, 1e7);
    } else if (editor_state.fly) {
        editor_state.viewpoint.fly(0, 0, editor_state.viewpoint.distance() * (1 - factor));
    } else {
        editor_state.viewpoint.approach(factor);
    }
    return true;
}

bool Navigator::drag(EditorState& editor_state) {
    const ImGuiIO& io = ImGui::GetIO();
    if (ImGui::IsMouseClicked(ImGuiMouseButton_Left) && !io.WantCaptureMouse) {
        m_pressed = true;
        m_dragged = false;
        m_pressed_at = {io.MousePos.x, io.MousePos.y};
    }
    bool moved = false;
    if (!io.WantCaptureMouse && io.MouseWheel != 0)
        moved |= closer(editor_state, std::pow(0.9, static_cast<double>(io.MouseWheel)));
    if (m_pressed &&
        std::abs(io.MousePos.x - m_pressed_at[0]) + std::abs(io.MousePos.y - m_pressed_at[1]) >
            kDrag_px)
        m_dragged = true;
    const double dx = static_cast<double>(io.MouseDelta.x);
    const double dy = static_cast<double>(io.MouseDelta.y);
    if (m_pressed && m_dragged && (dx != 0 || dy != 0)) {
        if (editor_state.fly)
            editor_state.viewpoint.look(dx * kDegreesPerPixel, dy * kDegreesPerPixel);
        else
            editor_state.viewpoint.orbit(dx * kDegreesPerPixel, dy * kDegreesPerPixel);
        moved = true;
    }
    if (!io.WantCaptureMouse &&
        (ImGui::IsMouseDown(ImGuiMouseButton_Right) ||
         ImGui::IsMouseDown(ImGuiMouseButton_Middle)) &&
        (dx != 0 || dy != 0)) {
        // The point under the mouse follows it approximately.
        const double voxels = editor_state.viewpoint.distance() /
                              static_cast<double>(std::max(io.DisplaySize.y, 1.0f));
        editor_state.viewpoint.walk(-dx * voxels, 0, dy * voxels);
        moved = true;
    }
    m_moving |= m_pressed || ImGui::IsMouseDown(ImGuiMouseButton_Right) ||
                ImGui::IsMouseDown(ImGuiMouseButton_Middle);
    if (ImGui::IsMouseReleased(ImGuiMouseButton_Left) && m_pressed) {
        if (!m_dragged)
            m_click = Click{static_cast<double>(m_pressed_at[0]),
                            static_cast<double>(m_pressed_at[1]), false};
        m_pressed = false;
    }
    if (ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left) && !io.WantCaptureMouse) {
        m_click =
            Click{static_cast<double>(io.MousePos.x), static_cast<double>(io.MousePos.y), true};
        m_pressed = false;
    }
    return moved;
}

bool Navigator::keys(EditorState& editor_state, const Keyboard& keyboard, double seconds) {
    const ImGuiIO& io = ImGui::GetIO();
    // A key of a command, such as Ctrl+S, does not move the viewpoint if Ctrl is released first.
    std::erase_if(m_commands, [&](int key) { return !keyboard.down(key); });
    if (Window::typing() || keyboard.ctrl() || keyboard.super()) {
        for (const int key : kMoving)
            if (keyboard.down(key))
                m_commands.insert(key);
        return false;
    }
    const auto down = [&](int key) {
        return keyboard.down(key) && !m_commands.contains(key) ? 1.0 : 0.0;
    };
    const auto axis = [&](int minus, int plus) { return down(plus) - down(minus); };
    const double right = axis(GLFW_KEY_A, GLFW_KEY_D);
    const double ahead = axis(GLFW_KEY_S, GLFW_KEY_W);
    const double up = axis(GLFW_KEY_Q, GLFW_KEY_E);
    const double turn = io.NavActive ? 0 : axis(GLFW_KEY_LEFT, GLFW_KEY_RIGHT);
    const double tilt = io.NavActive ? 0 : axis(GLFW_KEY_DOWN, GLFW_KEY_UP);
    const double nearer = io.NavActive ? 0 : axis(GLFW_KEY_PAGE_DOWN, GLFW_KEY_PAGE_UP);
    const double step = reach(editor_state) * seconds;
    const double degrees = kDegreesPerSecond * seconds;
    if (right != 0 || ahead != 0 || up != 0) {
        if (editor_state.fly)
            editor_state.viewpoint.fly(right * step, up * step, ahead * step);
        else
            editor_state.viewpoint.walk(right * step, up * step, ahead * step);
    }
    if (turn != 0 || tilt != 0) {
        if (editor_state.fly)
            editor_state.viewpoint.look(turn * degrees, -tilt * degrees);
        else
            editor_state.viewpoint.orbit(-turn * degrees, tilt * degrees);
    }
    if (nearer != 0)
        (void)closer(editor_state, std::pow(0.4, nearer * seconds));
    const bool moved = right != 0 || ahead != 0 || up != 0 || turn != 0 || tilt != 0 || nearer != 0;
    m_moving |= moved;
    return moved;
}

}  // namespace terravox::preview
