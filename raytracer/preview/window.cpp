#include "raytracer/preview/window.hpp"

// OpenGL 3.x functions by their prototypes: Mesa, NVIDIA and GLVND export them all.
#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
#include <GL/glext.h>
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <string>
#include <utility>

#include "common/util/error.hpp"

namespace terravox {
namespace {

std::string glfw_reason() {
    const char* text = nullptr;
    return glfwGetError(&text) != GLFW_NO_ERROR && text != nullptr ? text : "no reason given";
}

}  // namespace

Window::Window(int width_px, int height_px, const char* title) {
    if (glfwInit() == GLFW_FALSE)
        throw Error("open the preview window: " + glfw_reason() + "; without a display, use: terravox render ... -o picture.png");
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    m_window = glfwCreateWindow(width_px, height_px, title, nullptr, nullptr);
    if (m_window == nullptr) {
        const std::string reason = glfw_reason();
        glfwTerminate();
        throw Error("open the preview window: " + reason + "; OpenGL 3.3 is needed (Mesa's llvmpipe will do)");
    }
    glfwMakeContextCurrent(m_window);
    glfwSwapInterval(1);
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;  // no files left in the person's folder
    ImGui::StyleColorsDark();
    ImGui_ImplGlfw_InitForOpenGL(m_window, true);
    ImGui_ImplOpenGL3_Init("#version 330");
    glGenTextures(1, &m_texture);
    glGenFramebuffers(1, &m_framebuffer);
}

Window::~Window() {
    glDeleteFramebuffers(1, &m_framebuffer);
    glDeleteTextures(1, &m_texture);
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
    glfwDestroyWindow(m_window);
    glfwTerminate();
}

bool Window::open() const noexcept { return glfwWindowShouldClose(m_window) == GLFW_FALSE; }

void Window::close() noexcept { glfwSetWindowShouldClose(m_window, GLFW_TRUE); }

std::pair<int, int> Window::size_px() const noexcept {
    int width = 0, height = 0;
    glfwGetFramebufferSize(m_window, &width, &height);
    return {width, height};
}

void Window::begin_frame(double wait_s) {
    glfwWaitEventsTimeout(wait_s);
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
}

void Window::set_picture(const std::vector<std::uint8_t>& rgb, int width_px, int height_px) {
    glBindTexture(GL_TEXTURE_2D, m_texture);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, width_px, height_px, 0, GL_RGB, GL_UNSIGNED_BYTE, rgb.data());
    m_picture_width = width_px, m_picture_height = height_px;
}

void Window::end_frame() {
    ImGui::Render();
    const auto [width, height] = size_px();
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
    glClearColor(0.1f, 0.1f, 0.1f, 1);
    glClear(GL_COLOR_BUFFER_BIT);
    if (m_picture_width > 0 && width > 0 && height > 0) {
        // Copies the texture; flipped, because OpenGL counts rows from the bottom.
        glBindFramebuffer(GL_READ_FRAMEBUFFER, m_framebuffer);
        glFramebufferTexture2D(GL_READ_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, m_texture, 0);
        glBlitFramebuffer(0, m_picture_height, m_picture_width, 0, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_LINEAR);
        glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
    }
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    glfwSwapBuffers(m_window);
}

}  // namespace terravox
