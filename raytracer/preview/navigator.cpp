#include "raytracer/preview/navigator.hpp"

#include <GLFW/glfw3.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

namespace terravox {
namespace {

constexpr double kDegreesPerPixel = 0.25, kPadDegreesPerSecond = 90;
constexpr float kDrag_px = 4;            // less is a click
constexpr double kReachPerSecond = 0.9;  // of the distance to the target
constexpr double kFast = 4, kSlow = 0.25;
constexpr std::array kMoving{GLFW_KEY_A,  GLFW_KEY_D,    GLFW_KEY_S,       GLFW_KEY_W,
                             GLFW_KEY_Q,  GLFW_KEY_E,    GLFW_KEY_LEFT,    GLFW_KEY_RIGHT,
                             GLFW_KEY_UP, GLFW_KEY_DOWN, GLFW_KEY_PAGE_UP, GLFW_KEY_PAGE_DOWN};

bool parallel(const Scene& scene) {
    return is_parallel(scene.camera.projection);
}

}  // namespace

bool Navigator::handle(Desk& desk, const Gamepad& gamepad, double seconds) {
    m_click.reset();
    m_moving = false;
    const Viewpoint before = desk.viewpoint;
    const std::optional<double> height = desk.scene.camera.height_m;
    bool moved = drag(desk);
    moved |= keys(desk, seconds);
    moved |= pad(desk, gamepad, seconds);
    if (!moved || (before == desk.viewpoint && height == desk.scene.camera.height_m))
        return false;
    desk.moved();
    return true;
}

// How far one goes in a second, voxels.
double Navigator::reach(const Desk& desk) const noexcept {
    const ImGuiIO& io = ImGui::GetIO();
    return desk.viewpoint.distance() * kReachPerSecond *
           (io.KeyShift ? kFast
            : io.KeyAlt ? kSlow
                        : 1);
}

bool Navigator::closer(Desk& desk, double factor) {
    // Of parallel rays only what the picture's height covers says how near one is.
    if (parallel(desk.scene)) {
        const Camera camera = make_camera(desk.scene, desk.info(), desk.info().framed_bounds());
        const double height_m = desk.scene.camera.height_m.value_or(
            camera.pixel_voxels(0) * desk.scene.output.size_px[1] * desk.info().voxel_m);
        desk.scene.camera.height_m = std::clamp(height_m * factor, 0.1, 1e7);
    } else if (desk.fly) {
        desk.viewpoint.fly(0, 0, desk.viewpoint.distance() * (1 - factor));
    } else {
        desk.viewpoint.approach(factor);
    }
    return true;
}

bool Navigator::drag(Desk& desk) {
    const ImGuiIO& io = ImGui::GetIO();
    if (ImGui::IsMouseClicked(ImGuiMouseButton_Left) && !io.WantCaptureMouse)
        m_pressed = true, m_dragged = false, m_pressed_at = {io.MousePos.x, io.MousePos.y};
    bool moved = false;
    if (!io.WantCaptureMouse && io.MouseWheel != 0)
        moved |= closer(desk, std::pow(0.9, static_cast<double>(io.MouseWheel)));
    if (m_pressed &&
        std::abs(io.MousePos.x - m_pressed_at[0]) + std::abs(io.MousePos.y - m_pressed_at[1]) >
            kDrag_px)
        m_dragged = true;
    const double dx = static_cast<double>(io.MouseDelta.x),
                 dy = static_cast<double>(io.MouseDelta.y);
    if (m_pressed && m_dragged && (dx != 0 || dy != 0)) {
        if (desk.fly)
            desk.viewpoint.look(dx * kDegreesPerPixel, dy * kDegreesPerPixel);
        else
            desk.viewpoint.orbit(dx * kDegreesPerPixel, dy * kDegreesPerPixel);
        moved = true;
    }
    if (!io.WantCaptureMouse &&
        (ImGui::IsMouseDown(ImGuiMouseButton_Right) ||
         ImGui::IsMouseDown(ImGuiMouseButton_Middle)) &&
        (dx != 0 || dy != 0)) {
        // What lies under the mouse goes along with it, about.
        const double voxels =
            desk.viewpoint.distance() / static_cast<double>(std::max(io.DisplaySize.y, 1.0f));
        desk.viewpoint.walk(-dx * voxels, 0, dy * voxels);
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
    if (ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left) && !io.WantCaptureMouse)
        m_click =
            Click{static_cast<double>(io.MousePos.x), static_cast<double>(io.MousePos.y), true},
        m_pressed = false;
    return moved;
}

bool Navigator::keys(Desk& desk, double seconds) {
    const ImGuiIO& io = ImGui::GetIO();
    // A key of a command, as Ctrl+S, does not move when Ctrl is let go first.
    std::erase_if(m_commands, [](int key) { return !ImGui::IsKeyDown(key); });
    if (Window::typing() || io.KeyCtrl || io.KeySuper) {
        for (const int key : kMoving)
            if (ImGui::IsKeyDown(key))
                m_commands.insert(key);
        return false;
    }
    const auto down = [&](int key) {
        return ImGui::IsKeyDown(key) && !m_commands.contains(key) ? 1.0 : 0.0;
    };
    const auto axis = [&](int minus, int plus) { return down(plus) - down(minus); };
    const double right = axis(GLFW_KEY_A, GLFW_KEY_D), ahead = axis(GLFW_KEY_S, GLFW_KEY_W),
                 up = axis(GLFW_KEY_Q, GLFW_KEY_E);
    const double turn = io.NavActive ? 0 : axis(GLFW_KEY_LEFT, GLFW_KEY_RIGHT),
                 tilt = io.NavActive ? 0 : axis(GLFW_KEY_DOWN, GLFW_KEY_UP);
    const double nearer = io.NavActive ? 0 : axis(GLFW_KEY_PAGE_DOWN, GLFW_KEY_PAGE_UP);
    const double step = reach(desk) * seconds, degrees = kPadDegreesPerSecond / 2 * seconds;
    if (right != 0 || ahead != 0 || up != 0) {
        if (desk.fly)
            desk.viewpoint.fly(right * step, up * step, ahead * step);
        else
            desk.viewpoint.walk(right * step, up * step, ahead * step);
    }
    if (turn != 0 || tilt != 0) {
        if (desk.fly)
            desk.viewpoint.look(turn * degrees, -tilt * degrees);
        else
            desk.viewpoint.orbit(-turn * degrees, tilt * degrees);
    }
    if (nearer != 0)
        (void)closer(desk, std::pow(0.4, nearer * seconds));
    const bool moved = right != 0 || ahead != 0 || up != 0 || turn != 0 || tilt != 0 || nearer != 0;
    m_moving |= moved;
    return moved;
}

bool Navigator::pad(Desk& desk, const Gamepad& p, double seconds) {
    if (p.left_x == 0 && p.left_y == 0 && p.right_x == 0 && p.right_y == 0 && p.left_trigger == 0 &&
        p.right_trigger == 0)
        return false;
    const double step = reach(desk) * seconds, degrees = kPadDegreesPerSecond * seconds;
    desk.viewpoint.fly(p.left_x * step, (p.right_trigger - p.left_trigger) * step,
                       -p.left_y * step);
    desk.viewpoint.look(p.right_x * degrees, p.right_y * degrees);
    return m_moving = true;
}

}  // namespace terravox
