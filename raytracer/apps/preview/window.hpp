#pragma once

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "raytracer/apps/preview/input_queue.hpp"
#include "raytracer/apps/preview/layers.hpp"
#include "raytracer/apps/preview/pane.hpp"

struct GLFWwindow;

namespace terravox::preview {

/// A picture in the memory of the graphics driver. Lives no longer than the window.
class Texture {
public:
    Texture() = default;
    ~Texture();
    Texture(const Texture&) = delete;
    Texture& operator=(const Texture&) = delete;
    /// Uploads a picture; if the size is unchanged, only these rows.
    void set(const ScreenPicture& picture, int first_row, int end_row);
    /// The name that OpenGL gave it; 0: nothing was set.
    [[nodiscard]] unsigned name() const noexcept { return m_name; }
    [[nodiscard]] int width_px() const noexcept { return m_width; }
    [[nodiscard]] int height_px() const noexcept { return m_height; }

private:
    unsigned m_name = 0;
    int m_width = 0;
    int m_height = 0;
};

/// A GLFW window with an OpenGL 3.3 context, Dear ImGui, and one picture. Use from the main thread
/// only.
class Window {
public:
    /// @param scale of text and handles, 1 on a plain monitor; 0: the monitor's content scale
    /// @throws Error when there is no display or no OpenGL 3.3
    Window(int width_px, int height_px, const char* title, double scale);
    ~Window();

    [[nodiscard]] bool open() const noexcept;
    void close() noexcept;
    void set_title(const std::string& title);
    /// Waits for input for at most wait_s, handles it, and begins a frame with the style of the
    /// monitor's scale.
    void begin_frame(double wait_s);
    /// Draws the picture in its pane, panels and marks over it, and shows the frame.
    void end_frame(const Pane& pane);
    [[nodiscard]] Texture& picture() noexcept { return *m_picture; }
    /// Size of the drawing area, pixels; 0, 0 while it is minimized.
    [[nodiscard]] std::pair<int, int> size_px() const noexcept;
    /// Whether the current frame has any input.
    [[nodiscard]] bool had_input() const noexcept { return m_had_input; }
    [[nodiscard]] const Keyboard& keyboard() const noexcept { return m_keyboard; }
    [[nodiscard]] double scale() const noexcept { return m_scale; }
    void set_light(bool light) noexcept { m_light = light; }  ///< from the next frame on
    void copy_text(const std::string& text);
    /// The key of a letter, 'a' to 'z', in the user's keyboard layout; GLFW's own numbers are those
    /// of the US layout.
    [[nodiscard]] static int to_key(char letter);
    /// Whether a text field takes the keys of this frame.
    [[nodiscard]] static bool typing() noexcept;
    void hide() noexcept;
    /// Files that were dropped on the window since the last call.
    [[nodiscard]] std::vector<std::string> take_dropped() { return std::exchange(m_dropped, {}); }

private:
    void restyle();
    void queue_input();
    void hand_over(const InputEvent& event);
    void hand_over_state();
    GLFWwindow* m_window = nullptr;
    std::unique_ptr<Texture> m_picture;  ///< destroyed before the context
    unsigned m_framebuffer = 0;
    const double m_requested_scale;
    double m_scale = 1;
    bool m_light = false;
    std::pair<double, bool> m_styled{0, false};  ///< scale and light that the style is for
    std::vector<std::string> m_dropped;
    InputQueue m_input;  ///< events that Dear ImGui has not received yet
    Keyboard m_keyboard;
    bool m_had_input = false;
    CursorInput m_cursor;  ///< position in the last event that it has received
    std::array<bool, 5> m_buttons_down{};
};

}  // namespace terravox::preview
