#include "raytracer/apps/preview/app/app.hpp"

#include <imgui.h>
#include <algorithm>
#include <utility>

#include "common/util/error.hpp"
#include "common/util/log.hpp"

namespace terravox::preview {
namespace {

constexpr int kMap_px = 240;
constexpr double kMaxPassed_s = 0.1;  // a slow frame must not move the viewpoint far

/// Whether boxes are fetched from another machine, where a retry may succeed.
bool is_remote(const render::LoadedWorld& world) {
    return world.inputs.front().find("://") != std::string::npos;
}

}  // namespace

App::App(Window& window, scene::Scene scene, std::shared_ptr<render::LoadedWorld> world,
         const AppOptions& options)
    : m_window(window),
      m_editor_state(std::move(scene), std::move(world)),
      m_picture(options.render_pool, m_editor_state.world->blocks, m_editor_state.world->source,
                m_times),
      m_map(m_editor_state, static_cast<int>(kMap_px * m_window.scale())),
      m_pick(m_editor_state.world->blocks),
      m_side_panel({options.scene_file, options.final_render_pool}),
      m_notices(options.log),
      m_pacer(Clock::now()),
      m_history_recorder(m_pacer.began()) {
    m_editor_state.light = options.light;
    m_picture.note_change(m_pacer.began());
    ImGui::SetWindowFocus(nullptr);  // so that arrow keys turn the view, not the panel
}

App::~App() {
    m_picture.stop();
    m_final.stop();
    m_editor_state.world->blocks.stop();  // ends all waits for boxes
}

Activity App::activity() const {
    const auto [width, height] = m_window.size_px();
    if (width == 0 || height == 0)
        return Activity::kIdle;  // minimized
    if (m_picture.busy() || m_map.busy())
        return Activity::kComputing;
    const bool animated =
        m_navigator.moving() || m_path.playing() || m_pick.busy() || m_pacer.is_settling();
    return animated ? Activity::kAnimated : Activity::kIdle;
}

void App::frame() {
    const double passed_s = wait_for_input();
    lay_out();
    show_notices();
    handle_input(passed_s);
    draw();
    note_history();
    update_picture();
    const auto drawn = Clock::now();
    work(m_pacer.work_until(drawn));
    const auto traced = Clock::now();
    show_picture();
    note_rest();
    m_pacer.end(drawn, traced, Clock::now());
}

double App::wait_for_input() {
    const double wait_s = FramePacer::wait_s(activity());
    const auto waiting_since = Clock::now();
    m_window.begin_frame(wait_s);
    const double passed_s =
        m_pacer.begin(waiting_since, wait_s, m_window.had_input(), Clock::now());
    if (wait_s == 0)
        m_times.frame(passed_s);
    return std::min(passed_s, kMaxPassed_s);
}

void App::lay_out() {
    const auto [width, height] = m_window.size_px();
    if (width > 0 && height > 0)
        m_window_px = {width, height};
    m_pane =
        pane_in(m_window_px, static_cast<int>(SidePanel::width_px(m_editor_state, m_window_px)),
                m_editor_state.fills ? std::array{0, 0} : m_editor_state.scene.output.size_px);
}

void App::show_notices() {
    for (Notice& notice : m_notices.take(m_editor_state.world->blocks, m_final.status())) {
        if (notice.logged)
            m_editor_state.show_logged(std::move(notice.text));
        else
            m_editor_state.notify(std::move(notice.text), notice.bad);
    }
}

void App::handle_input(double passed_s) {
    for (const std::string& file : m_window.take_dropped())
        m_side_panel.files().open_scene(m_editor_state, file);
    handle_shortcuts({m_window, m_editor_state, m_picture.progressive(), m_final,
                      m_side_panel.files(), m_path, m_pick, m_pane});
    m_navigator.handle(m_editor_state, m_window.keyboard(), passed_s);
    if (const auto& click = m_navigator.click())
        m_pick.click(m_editor_state, *click, m_pane, m_picture.progressive().view());
    m_pick.update(m_editor_state);
    const Progressive& picture = m_picture.progressive();
    m_path.play(m_editor_state, picture.whole() || !picture.busy());
    m_window.set_light(m_editor_state.light);
}

void App::draw() {
    const Progressive& picture = m_picture.progressive();
    m_side_panel.draw(m_editor_state, m_pick, m_picture, m_final, m_window_px);
    const float panel_px = SidePanel::width_px(m_editor_state, m_window_px);
    const auto right = static_cast<float>(m_window_px[0]);
    const auto lower = static_cast<float>(m_window_px[1]);
    panels::draw_status(m_editor_state,
                        {picture.status(), picture.busy(), m_times.frame_s(), m_picture.missing()},
                        panel_px, right);
    const float margin = ImGui::GetFontSize();
    const float flight_px = m_path.draw(m_editor_state, panel_px, m_window_px);
    const float map_lower = lower - margin - (flight_px > 0 ? flight_px + margin : 0);
    m_map.draw(m_editor_state, m_pick, picture.view(), {right - margin, map_lower});
    if (picture.view())
        m_pick.draw(m_editor_state, *picture.view(), m_pane, m_window_px);
    panels::draw_help(m_editor_state, m_window_px);
}

void App::note_history() {
    const bool busy = m_navigator.moving() || ImGui::IsAnyItemActive() || m_path.playing();
    m_history_recorder.update(m_editor_state.history, m_editor_state.scene, busy, Clock::now());
}

void App::update_picture() {
    if (m_window_px[0] == 0)
        return;
    const auto now = Clock::now();
    // A retry is useless for files; and during a final picture a box must not change, so that all
    // tiles are of the same world.
    const bool may_retry = is_remote(*m_editor_state.world) && !m_final.runs();
    const bool missing_box_arrived = m_picture.has_missing_box_arrived(may_retry, now);
    if (missing_box_arrived)
        m_map.begin_again();
    const scene::Scene wanted = scene_to_show(m_editor_state.layer, m_editor_state.scene,
                                              m_editor_state.resolution, m_pane);
    m_editor_state.attempt([&] {
        m_picture.update(wanted, m_editor_state.layer, missing_box_arrived, m_pacer.began(), now);
    });
}

void App::work(Clock::time_point until) {
    const Progressive& picture = m_picture.progressive();
    try {
        // The map gets a share of the time, a small one until the first picture. It is never zero:
        // boxes that were loaded for the map stay in memory until it has read them, and may leave
        // no room for the picture's.
        const bool map_too =
            m_map.busy() && !m_navigator.moving() && (picture.whole() || !picture.busy());
        const auto now = Clock::now();
        m_picture.work(map_too ? now + (until - now) / 2 : until);
        if (m_map.busy())
            m_map.work(map_too ? until : now);
    } catch (const processors::PictureInvalidated& e) {
        m_picture.invalidate();
        m_editor_state.notify(e.what(), true);
    } catch (const util::Error& e) {
        m_picture.forget_change();
        m_editor_state.notify(e.what(), true);
    }
}

void App::show_picture() {
    const RowRange rows = m_picture.develop(m_editor_state.scene.output);
    if (!rows.empty())
        m_window.picture().set(m_picture.screen(), rows.first, rows.end);
    m_window.end_frame(m_pane);
    m_picture.note_shown(Clock::now());
}

// Logs that nothing is in progress, and the window stays unchanged until the next input.
void App::note_rest() {
    const bool rests =
        activity() == Activity::kIdle && m_editor_state.scene == m_editor_state.history.now();
    if (m_pacer.comes_to_rest(rests))
        util::log_debug("at rest");
}

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
