#include "raytracer/apps/preview/window.hpp"

// OpenGL 3.x functions by their prototypes: Mesa, NVIDIA and GLVND export them all.
#define GL_GLEXT_PROTOTYPES
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <GL/gl.h>
#include <GL/glext.h>
#include <GLFW/glfw3.h>
#include <imgui.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstdlib>

#include "common/util/error.hpp"

namespace terravox::preview {
namespace {

constexpr double kMaxScale = 4;
constexpr float kText_px = 13;  // the size that the built-in font is drawn for

#ifdef GLFW_PLATFORM
// Ref: libwayland, wl_display_connect: a name without a slash at its front is one in that folder.
bool may_have_wayland() {
    const char* const name = std::getenv("WAYLAND_DISPLAY");
    const char* const folder = std::getenv("XDG_RUNTIME_DIR");
    return (name != nullptr && name[0] == '/') || (folder != nullptr && folder[0] == '/');
}
#endif

std::string glfw_reason() {
    const char* text = nullptr;
    return glfwGetError(&text) != GLFW_NO_ERROR && text != nullptr ? text : "no reason given";
}

constexpr CursorInput kNowhere{-static_cast<double>(FLT_MAX),
                               -static_cast<double>(FLT_MAX)};  // Dear ImGui's value for no mouse

bool any_button_down(GLFWwindow* window) {
    for (int button = 0; button <= GLFW_MOUSE_BUTTON_LAST; ++button)
        if (glfwGetMouseButton(window, button) == GLFW_PRESS)
            return true;
    return false;
}

constexpr const char* kInstead = "; without a window: terravox render WORLD -o picture.png";

}  // namespace

Texture::~Texture() {
    if (m_name != 0)
        glDeleteTextures(1, &m_name);
}

void Texture::set(const ScreenPicture& picture, int first_row, int end_row) {
    if (m_name == 0) {
        glGenTextures(1, &m_name);
        glBindTexture(GL_TEXTURE_2D, m_name);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    }
    glBindTexture(GL_TEXTURE_2D, m_name);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    if (m_width != picture.width_px || m_height != picture.height_px) {
        glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, picture.width_px, picture.height_px, 0, GL_RGB,
                     GL_UNSIGNED_BYTE, picture.rgb.data());
        m_width = picture.width_px;
        m_height = picture.height_px;
        return;
    }
    const std::size_t offset =
        static_cast<std::size_t>(first_row) * static_cast<std::size_t>(m_width) * 3;
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, first_row, m_width, end_row - first_row, GL_RGB,
                    GL_UNSIGNED_BYTE, picture.rgb.data() + offset);
}

Window::Window(int width_px, int height_px, const char* title, double scale)
    : m_requested_scale(scale) {
#ifdef GLFW_PLATFORM
    // From 3.4 on GLFW tries Wayland first, and its library then prints a line of its own where
    // there is no folder for its sockets.
    if (!may_have_wayland())
        glfwInitHint(GLFW_PLATFORM, GLFW_PLATFORM_X11);
#endif
    if (glfwInit() == GLFW_FALSE)
        throw util::Error("open the preview window: " + glfw_reason() + kInstead);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
    m_window = glfwCreateWindow(width_px, height_px, title, nullptr, nullptr);
    if (m_window == nullptr) {
        const std::string reason = glfw_reason();
        glfwTerminate();
        throw util::Error("open the preview window: " + reason +
                          "; OpenGL 3.3 is needed, Mesa's llvmpipe will do" + kInstead);
    }
    glfwMakeContextCurrent(m_window);
    // Tracing is limited by time: waiting for the vertical sync would reduce it.
    glfwSwapInterval(0);
    glfwSetWindowUserPointer(m_window, this);
    glfwSetDropCallback(m_window, [](GLFWwindow* w, int count, const char** paths) noexcept {
        auto& dropped = static_cast<Window*>(glfwGetWindowUserPointer(w))->m_dropped;
        dropped.insert(dropped.end(), paths, paths + count);
    });
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;  // no file is written to the working folder
    ImGui::GetIO().ConfigFlags |= ImGuiConfigFlags_NavEnableKeyboard;
#if IMGUI_VERSION_NUM >= 18700
    // Our queue splits events into frames; what it hands over is of one.
    ImGui::GetIO().ConfigInputTrickleEventQueue = false;
#endif
    ImGui_ImplGlfw_InitForOpenGL(m_window, true);
    queue_input();
    ImGui_ImplOpenGL3_Init("#version 330");
    glGenFramebuffers(1, &m_framebuffer);
    m_picture = std::make_unique<Texture>();
}

Window::~Window() {
    m_picture.reset();
    glDeleteFramebuffers(1, &m_framebuffer);
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
    glfwDestroyWindow(m_window);
    glfwTerminate();
}

bool Window::open() const noexcept {
    return glfwWindowShouldClose(m_window) == GLFW_FALSE;
}
void Window::close() noexcept {
    glfwSetWindowShouldClose(m_window, GLFW_TRUE);
}
void Window::set_title(const std::string& title) {
    glfwSetWindowTitle(m_window, title.c_str());
}
void Window::copy_text(const std::string& text) {
    glfwSetClipboardString(m_window, text.c_str());
}

std::pair<int, int> Window::size_px() const noexcept {
    int width = 0;
    int height = 0;
    glfwGetFramebufferSize(m_window, &width, &height);
    return {width, height};
}

// Starts from the default style each time, as sizes are scaled once. Only while Dear ImGui draws
// nothing.
void Window::restyle() {
    ImGuiStyle style;
    m_light ? ImGui::StyleColorsLight(&style) : ImGui::StyleColorsDark(&style);
    style.WindowRounding = 4;
    style.FrameRounding = 3;
    style.GrabRounding = 3;
    style.Colors[ImGuiCol_WindowBg].w = 0.94f;
    style.ScaleAllSizes(static_cast<float>(m_scale));
    const float text_px = std::round(kText_px * static_cast<float>(m_scale));
#if IMGUI_VERSION_NUM >= 19200
    style.FontSizeBase = text_px;  // glyphs are drawn when they are needed, in any size
    ImGui::GetStyle() = style;
#else
    ImGui::GetStyle() = style;
    if (m_scale != m_styled.first) {
        ImFontConfig font;
        font.SizePixels = text_px;
        ImGui::GetIO().Fonts->Clear();
        ImGui::GetIO().Fonts->AddFontDefault(&font);
        // Not all that it has of OpenGL: 1.86 would take its new, empty buffers for as large as the
        // old ones.
        ImGui_ImplOpenGL3_DestroyFontsTexture();
        ImGui_ImplOpenGL3_CreateFontsTexture();
    }
#endif
    m_styled = {m_scale, m_light};
}

// Replaces the callbacks that Dear ImGui has installed, with which it would receive events at once.
void Window::queue_input() {
    m_cursor = kNowhere;
    static constexpr auto kQueue = [](GLFWwindow* window) -> InputQueue& {
        return static_cast<Window*>(glfwGetWindowUserPointer(window))->m_input;
    };
    glfwSetKeyCallback(
        m_window, [](GLFWwindow* w, int key, int scancode, int action, int mods) noexcept {
            kQueue(w).push(
                KeyInput{key, scancode, mods, action != GLFW_RELEASE, action == GLFW_REPEAT});
        });
    glfwSetCharCallback(m_window, [](GLFWwindow* w, unsigned code_point) noexcept {
        kQueue(w).push(CharacterInput{code_point});
    });
    glfwSetCursorPosCallback(m_window, [](GLFWwindow* w, double x, double y) noexcept {
        kQueue(w).push(CursorInput{x, y});
    });
    glfwSetMouseButtonCallback(m_window, [](GLFWwindow* w, int button, int action, int) noexcept {
        kQueue(w).push(ButtonInput{button, action == GLFW_PRESS});
    });
    glfwSetScrollCallback(m_window, [](GLFWwindow* w, double x, double y) noexcept {
        kQueue(w).push(WheelInput{x, y});
    });
    glfwSetCursorEnterCallback(m_window, [](GLFWwindow* w, int entered) noexcept {
        CursorInput cursor = kNowhere;
        if (entered == GLFW_TRUE)
            glfwGetCursorPos(w, &cursor.x, &cursor.y);
        // A drag continues outside of the window, with positions there.
        else if (any_button_down(w))
            return;
        kQueue(w).push(cursor);
    });
}

void Window::hand_over(const InputEvent& event) {
    if (const auto* key = std::get_if<KeyInput>(&event)) {
        // Dear ImGui repeats keys itself.
        if (!key->repeats)
            ImGui_ImplGlfw_KeyCallback(m_window, key->key, key->scancode,
                                       key->down ? GLFW_PRESS : GLFW_RELEASE, key->mods);
    } else if (const auto* character = std::get_if<CharacterInput>(&event)) {
        ImGui_ImplGlfw_CharCallback(m_window, character->code_point);
    } else if (const auto* wheel = std::get_if<WheelInput>(&event)) {
        ImGui_ImplGlfw_ScrollCallback(m_window, wheel->x, wheel->y);
    } else if (const auto* cursor = std::get_if<CursorInput>(&event)) {
        m_cursor = *cursor;
    } else if (const auto* button = std::get_if<ButtonInput>(&event)) {
        const auto number = static_cast<std::size_t>(button->button);
        if (number < m_buttons_down.size())
            m_buttons_down[number] = button->down;
    }
}

// Its backend has read the mouse's position, and since 1.89 the modifiers, as they are now: ahead
// of events that are still in the queue.
void Window::hand_over_state() {
    ImGuiIO& io = ImGui::GetIO();
#if IMGUI_VERSION_NUM >= 18900
    io.AddKeyEvent(ImGuiMod_Ctrl, m_keyboard.ctrl());
    io.AddKeyEvent(ImGuiMod_Shift, m_keyboard.shift());
    io.AddKeyEvent(ImGuiMod_Alt, m_keyboard.alt());
    io.AddKeyEvent(ImGuiMod_Super, m_keyboard.super());
#endif
#if IMGUI_VERSION_NUM >= 18700
    io.AddMousePosEvent(static_cast<float>(m_cursor.x), static_cast<float>(m_cursor.y));
    for (std::size_t i = 0; i < m_buttons_down.size(); ++i)
        io.AddMouseButtonEvent(static_cast<int>(i), m_buttons_down[i]);
#else
    io.MousePos = {static_cast<float>(m_cursor.x), static_cast<float>(m_cursor.y)};
    std::copy(m_buttons_down.begin(), m_buttons_down.end(), io.MouseDown);
#endif
}

void Window::begin_frame(double wait_s) {
    wait_s > 0 && m_input.empty() ? glfwWaitEventsTimeout(wait_s) : glfwPollEvents();
    const std::vector<InputEvent> events = m_input.next_frame();
    m_had_input = !events.empty();
    m_keyboard.begin_frame(events);
    for (const InputEvent& event : events)
        hand_over(event);
    float x = 1;
    float y = 1;
    glfwGetWindowContentScale(m_window, &x, &y);
    m_scale =
        m_requested_scale > 0
            ? m_requested_scale
            : std::clamp(std::round(static_cast<double>(std::max(x, y)) * 4) / 4, 1.0, kMaxScale);
    ImGui_ImplOpenGL3_NewFrame();
    if (m_styled != std::pair(m_scale, m_light))
        restyle();
    ImGui_ImplGlfw_NewFrame();
    hand_over_state();
    ImGui::NewFrame();
}

// WantTextInput is still set in the frame after the one in which Return or Escape has left the
// field; no item is active then.
bool Window::typing() noexcept {
    return ImGui::GetIO().WantTextInput && ImGui::IsAnyItemActive();
}

void Window::hide() noexcept {
    glfwHideWindow(m_window);
}

int Window::to_key(char letter) {
    for (int key = GLFW_KEY_A; key <= GLFW_KEY_Z; ++key) {
        const char* name = glfwGetKeyName(key, 0);
        if (name != nullptr && name[0] == letter && name[1] == 0)
            return key;
    }
    return GLFW_KEY_A + (letter - 'a');
}

void Window::end_frame(const Pane& pane) {
    ImGui::Render();
    const auto [width, height] = size_px();
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
    glViewport(0, 0, width, height);
    m_light ? glClearColor(0.75f, 0.75f, 0.75f, 1) : glClearColor(0.1f, 0.1f, 0.1f, 1);
    glClear(GL_COLOR_BUFFER_BIT);
    if (m_picture->name() != 0 && width > 0 && height > 0) {
        // Copies the texture; flipped, because OpenGL counts rows from the bottom.
        glBindFramebuffer(GL_READ_FRAMEBUFFER, m_framebuffer);
        glFramebufferTexture2D(GL_READ_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D,
                               m_picture->name(), 0);
        const bool same =
            m_picture->width_px() == pane.width && m_picture->height_px() == pane.height;
        glBlitFramebuffer(0, m_picture->height_px(), m_picture->width_px(), 0, pane.x,
                          height - pane.y - pane.height, pane.x + pane.width, height - pane.y,
                          GL_COLOR_BUFFER_BIT, same ? GL_NEAREST : GL_LINEAR);
        glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
    }
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    glfwSwapBuffers(m_window);
}

}  // namespace terravox::preview
