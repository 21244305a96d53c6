#pragma once

#include <cstdint>
#include <vector>

struct GLFWwindow;

namespace terravox {

/// A GLFW window with an OpenGL 3.3 context, Dear ImGui, and one picture that fills it. Use from the main thread only.
class Window {
public:
    /// @throws Error when there is no display or no OpenGL 3.3
    Window(int width_px, int height_px, const char* title);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    [[nodiscard]] bool open() const noexcept;
    void close() noexcept;
    void begin_frame(double wait_s);  ///< handles input, waiting for some up to wait_s, and begins the panel
    void end_frame();                 ///< draws picture and panel
    /// @param rgb 8-bit, rows from the top
    void set_picture(const std::vector<std::uint8_t>& rgb, int width_px, int height_px);
    /// Size of the drawing area, pixels.
    [[nodiscard]] std::pair<int, int> size_px() const noexcept;

private:
    GLFWwindow* m_window = nullptr;
    unsigned m_texture = 0, m_framebuffer = 0;
    int m_picture_width = 0, m_picture_height = 0;
};

}  // namespace terravox
