#include "raytracer/apps/preview/app/session.hpp"

#include <imgui.h>

#include <algorithm>
#include <utility>

#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "raytracer/apps/preview/panels/widgets.hpp"

namespace terravox::preview {
namespace {

constexpr double kOpeningFrame_s = 0.05;
constexpr float kOpeningWidth_ems = 40;

}  // namespace

Session::Session(Window& window, worlds::WorldOptions from, scene::Scene scene, AppOptions options)
    : m_window(window),
      m_from(std::move(from)),
      m_scene(std::move(scene)),
      m_options(std::move(options)) {
    open();
}

void Session::open() {
    m_failure.clear();
    m_opening = std::make_unique<Opening>(m_from, m_scene);
}

void Session::frame() {
    if (m_app)
        return m_app->frame();
    m_window.begin_frame(kOpeningFrame_s);
    const bool again = draw_opening();
    m_window.end_frame({});
    if (again)
        open();
    take_world();
}

void Session::take_world() {
    if (auto world = m_opening->take()) {
        try {
            m_window.set_title("Terravox: " + world->world->info().title);
            m_app = std::make_unique<App>(m_window, m_scene, std::move(world), m_options);
        } catch (const util::Error& e) {
            m_failure = e.what();
        }
        return;
    }
    if (!m_failure.empty())
        return;
    m_failure = m_opening->failure();
    if (!m_failure.empty())
        util::log_error("{}", m_failure);
}

/// @return whether the world should be opened again
bool Session::draw_opening() {
    const auto [width, height] = m_window.size_px();
    ImGui::SetNextWindowPos({static_cast<float>(width) / 2, static_cast<float>(height) / 2},
                            ImGuiCond_Always, {0.5f, 0.5f});
    ImGui::SetNextWindowSize(
        {std::min(ImGui::GetFontSize() * kOpeningWidth_ems, static_cast<float>(std::max(width, 1))),
         0});
    ImGui::Begin("##opening", nullptr, ImGuiWindowFlags_NoDecoration);
    bool again = false;
    if (m_failure.empty()) {
        ImGui::Text("Opening the world %c", "|/-\\"[static_cast<int>(ImGui::GetTime() * 8) & 3]);
    } else {
        ImGui::TextWrapped("%s", m_failure.c_str());
        again = panels::widgets::button("Try again");
        ImGui::SameLine();
        if (panels::widgets::button("Close"))
            m_window.close();
    }
    ImGui::End();
    return again;
}

}  // namespace terravox::preview
