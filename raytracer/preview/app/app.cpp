#include "raytracer/preview/app/app.hpp"

#include <GLFW/glfw3.h>
#include <imgui.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/util/error.hpp"
#include "raytracer/preview/panels/form.hpp"
#include "raytracer/preview/panels/help.hpp"
#include "raytracer/preview/panels/scene_panels.hpp"
#include "raytracer/preview/panels/status_line.hpp"
#include "raytracer/preview/panels/widgets.hpp"

namespace terravox::preview {
namespace {

constexpr double kFrame_s = 1.0 / 60;
constexpr double kMinWork_s =
    0.004;  // of a frame, however long drawing takes: or nothing would come of it
constexpr double kIdle_s = 0.25;      // between two frames when nobody does anything
constexpr double kPatience_s = 0.05;  // so long a first pass may go on though the scene has
                                      // changed: or nothing would be seen of a flight
constexpr double kFirst_s = 0.03, kQuick_s = 0.008;  // what a first pass should take
constexpr int kCoarsest = 64, kFinest = 4;
constexpr double kSettled_s = 0.4;  // without a change, before undo can come back here
constexpr int kLivelyFrames = 3;    // after an event
constexpr double kProbeAgain_s = 0.5, kMaxProbeAgain_s = 16;
constexpr int kMap_px = 240;
constexpr float kPanel_ems = 28;

double seconds(std::chrono::steady_clock::duration d) {
    return std::chrono::duration<double>(d).count();
}
std::chrono::steady_clock::duration duration(double s) {
    return std::chrono::duration_cast<std::chrono::steady_clock::duration>(
        std::chrono::duration<double>(s));
}

/// What does not touch the light that a picture is made of.
void leave_out_developing(scene::Scene& scene) {
    const scene::Scene::Output usual;
    scene.output.exposure_ev = usual.exposure_ev;
    scene.output.tone = usual.tone;
    scene.output.tiff = usual.tiff;
    scene.output.credit = usual.credit;
    scene.output.denoise = usual.denoise;
}

}  // namespace

App::App(Window& window, scene::Scene scene, std::shared_ptr<render::LoadedWorld> world,
         const AppOptions& options)
    : m_window(window),
      m_editor_state(std::move(scene), std::move(world)),
      m_render_pool(options.render_pool, m_editor_state.world->blocks,
                    m_editor_state.world->source),
      m_picture(m_editor_state.world->blocks,
                [this](const shade::View& view) { return begin_picture(view); }),
      m_map(m_editor_state, static_cast<int>(kMap_px * m_window.scale())),
      m_pick(m_editor_state.world->blocks),
      m_holes(m_editor_state.world->blocks),
      m_files(options.scene_file, options.final_render_pool),
      m_frame_began(Clock::now()),
      m_settled(m_frame_began) {
    m_editor_state.light = options.light;
    m_far = m_editor_state.world->inputs.front().find("://") != std::string::npos;
    m_log = options.log;
    m_changed = m_frame_began;
    ImGui::SetWindowFocus(nullptr);  // so that arrow keys turn the view, not the panel
}

App::~App() {
    m_picture.stop();
    m_final.stop();
    m_editor_state.world->blocks.stop();  // nobody waits for a box any more
}

std::shared_ptr<processors::TileProcessor> App::begin_picture(const shade::View& view) {
    if (!is_probe(m_shown_layer))
        return m_render_pool.begin(view);
    m_probe = std::make_shared<ProbeProcessor>(view, m_editor_state.world->blocks, m_shown_layer);
    return m_probe;
}

double App::wait_s() const {
    const auto [width, height] = m_window.size_px();
    if (width == 0 || height == 0)
        return kIdle_s;  // minimized
    if (m_picture.busy() || m_map.busy() || m_changed)
        return 0;
    // Dear ImGui needs some frames until windows have the size that suits what is new in them.
    // Gamepads tell nothing by themselves.
    return m_moving || m_path.playing() || m_pick.busy() || m_lively > 0 || Window::has_gamepad()
               ? kFrame_s
               : kIdle_s;
}

/// Nothing is under way: what is seen stays as it is until somebody does something.
bool App::at_rest() const {
    return wait_s() == kIdle_s && m_editor_state.scene == m_editor_state.history.now();
}

void App::frame() {
    const double wait = wait_s();
    const bool worked = wait == 0;
    const auto waiting = Clock::now();
    m_window.begin_frame(wait);
    const auto began = Clock::now();
    const bool woken = m_window.had_input() || seconds(began - waiting) < wait * 0.9;
    m_lively = woken ? kLivelyFrames : std::max(m_lively - 1, 0);
    const double passed_s = std::min(seconds(began - m_frame_began), 0.1);
    if (worked)
        m_times.frame(seconds(began - m_frame_began));
    m_frame_began = began;
    const auto [width, height] = m_window.size_px();
    if (width > 0 && height > 0)
        m_window_px = {width, height};
    m_pane = pane_in(m_window_px, static_cast<int>(panel_px()),
                     m_editor_state.fills ? std::array{0, 0} : m_editor_state.scene.output.size_px);
    hear();
    for (const std::string& file : m_window.take_dropped())
        m_files.open_scene(m_editor_state, file);
    handle_keys();
    m_navigator.handle(m_editor_state, Window::gamepad(), passed_s);
    m_moving = m_navigator.moving();
    handle_clicks();
    m_pick.update(m_editor_state);
    m_path.play(m_editor_state, m_picture.whole() || !m_picture.busy());
    m_window.set_light(m_editor_state.light);
    draw();
    note_history();
    restart_if_changed(Clock::now());
    const auto drawn = Clock::now();
    work(std::max(began + duration(kFrame_s - m_drawing_s), drawn + duration(kMinWork_s)));
    const auto traced = Clock::now();
    show_changes();
    m_window.end_frame(m_pane);
    if (m_changed && m_picture.whole() && m_started >= *m_changed) {
        m_times.first_picture(seconds(Clock::now() - *m_changed));
        spdlog::debug("first picture after {:.1f} ms, step {}",
                      seconds(Clock::now() - *m_changed) * 1e3, m_first_step);
        m_changed.reset();
        choose_first_step();
    }
    if (const bool rests = at_rest(); std::exchange(m_rests, rests) != rests && rests)
        spdlog::debug("at rest");
    m_drawing_s = 0.8 * m_drawing_s +
                  0.2 * std::min(seconds(drawn - began) + seconds(Clock::now() - traced), kFrame_s);
}

// What happens elsewhere, of which the person sees nothing else.
void App::hear() {
    if (std::string line = m_log ? m_log->take() : ""; !line.empty())
        m_editor_state.heard(std::move(line));
    try {
        if (!m_world_changed)
            m_editor_state.world->blocks.check_world();
    } catch (const voxel::ChangedError& e) {
        m_world_changed = true;
        m_editor_state.say(e.what(), true);
    }
    const FinalRender::Status final_render = m_final.status();
    const bool runs = final_render.state == FinalRender::State::kRunning;
    if (std::exchange(m_final_ran, runs) && !runs)
        m_editor_state.say("the final picture: " + final_render.message,
                           final_render.state == FinalRender::State::kFailed &&
                               final_render.message != FinalRender::kGivenUp);
}

scene::Scene App::scene_to_show() const {
    scene::Scene out = scene_for(m_editor_state.layer, m_editor_state.scene);
    const auto scaled = [&](int px) {
        return std::max(static_cast<int>(std::lround(px * m_editor_state.resolution)), 1);
    };
    out.output.size_px = {scaled(m_pane.width), scaled(m_pane.height)};
    leave_out_developing(out);
    return out;
}

void App::restart_if_changed(Clock::time_point now) {
    if (m_window_px[0] == 0)
        return;
    if (m_picture.busy())
        m_idle_since = now;
    // Of files the same would come again; and a final picture has one answer for each box.
    const bool idle = m_far && !m_picture.busy() && !m_final.runs();
    const bool holes_have_come =
        m_holes.look(m_picture.holes(), idle ? std::optional(m_idle_since) : std::nullopt, now);
    if (holes_have_come) {
        spdlog::debug("a box that was a hole has come");
        m_map.begin_again();
    }
    const scene::Scene wanted = scene_to_show();
    const bool same_film =
        m_shown && terravox::preview::same_film(m_shown_layer, m_editor_state.layer);
    scene::Scene with_layers = wanted;  // a film that has more than this layer needs will do
    with_layers.output.layers = core::PictureLayers::kAll;
    const bool changed = !m_shown || !same_film ||
                         (wanted != *m_shown && with_layers != *m_shown) || holes_have_come;
    if (!changed) {
        if (m_shown_layer != m_editor_state.layer)
            m_develop_all = true;
        m_shown_layer = m_editor_state.layer;
        // Boxes that probes did not find may be there now; each pixel takes its place as it comes.
        if (!is_probe(m_editor_state.layer) || !m_probe || m_picture.busy() ||
            m_probe->missing() == 0)
            return;
        if (seconds(now - m_probed) < m_probe_wait_s)
            return;
        m_probe_wait_s = m_probe->missing() < m_probe_missing
                             ? kProbeAgain_s
                             : std::min(2 * m_probe_wait_s, kMaxProbeAgain_s);
        m_probe_missing = m_probe->missing();
        return start(wanted, 1, now);
    }
    if (!m_changed)
        m_changed = m_frame_began;
    // Of the newest change it will be the first picture; of an older one, which it has overtaken,
    // too.
    if (m_picture.busy() && !m_picture.whole() && seconds(now - m_started) < kPatience_s)
        return;
    m_shown_layer = m_editor_state.layer;
    m_probe_wait_s = kProbeAgain_s;
    m_probe_missing = std::numeric_limits<std::size_t>::max();
    start(wanted, m_first_step, now);
}

void App::start(const scene::Scene& wanted, int first_step, Clock::time_point now) {
    m_shown = wanted;
    m_started = m_probed = m_idle_since = now;
    m_develop_all = false;
    m_probe.reset();
    try {
        m_picture.start(wanted, first_step);
        m_screen.resize(wanted.output.size_px[0], wanted.output.size_px[1]);
        ++m_pictures;
    } catch (const util::Error& e) {
        m_changed.reset();
        m_editor_state.say(e.what(), true);
    }
    m_times.stop(m_picture.last_stop_s());
}

void App::choose_first_step() {
    const double first_s = m_picture.status().first_s;
    if (first_s > kFirst_s)
        m_first_step = std::min(m_first_step * 2, kCoarsest);
    else if (first_s < kQuick_s)
        m_first_step = std::max(m_first_step / 2, kFinest);
}

void App::work(Clock::time_point until) {
    try {
        // The map has a share, but not much before there is something to see. Some it always has:
        // boxes that have come for it stay in memory until it has looked at them, and the picture
        // may have no room for its own meanwhile.
        const bool map_too = m_map.busy() && !m_moving && (m_picture.whole() || !m_picture.busy());
        const auto now = Clock::now();
        m_picture.work(map_too ? now + (until - now) / 2 : until);
        if (m_map.busy())
            m_map.work(map_too ? until : now);
    } catch (const processors::PictureInvalidated& e) {
        m_shown.reset();  // it begins anew
        m_editor_state.say(e.what(), true);
    } catch (const util::Error& e) {
        m_changed.reset();
        m_editor_state.say(e.what(), true);
    }
}

void App::show_changes() {
    // After a scene that cannot be the film is that of the picture before.
    if (!m_picture.film() || m_picture.film()->width_px() != m_screen.width_px ||
        m_picture.film()->height_px() != m_screen.height_px)
        return;
    auto changes = m_picture.take_changes();
    const scene::Scene::Output& output = m_editor_state.scene.output;
    m_develop_all |=
        m_shown_output.exposure_ev != output.exposure_ev || m_shown_output.tone != output.tone;
    m_shown_output = output;
    if (m_develop_all && m_picture.whole()) {
        tiles::RenderTile all;
        all.x1 = m_screen.width_px;
        all.y1 = m_screen.height_px;
        changes = {all};
        m_develop_all = false;
    }
    int first = m_screen.height_px, end = 0;
    for (const tiles::RenderTile& tile : changes) {
        show(*m_picture.film(), *m_picture.view(), output, m_shown_layer, tile, m_screen);
        first = std::min(first, tile.y0);
        end = std::max(end, std::min(tile.y1 + tile.step, m_screen.height_px));
    }
    if (first < end)
        m_window.picture().set(m_screen, first, end);
}

void App::note_history() {
    const auto now = Clock::now();
    const bool busy = m_moving || ImGui::IsAnyItemActive() || m_path.playing();
    if (busy || m_last_scene != m_editor_state.scene) {
        m_settled = now;
        m_last_scene = m_editor_state.scene;
    }
    if (!busy && seconds(now - m_settled) > kSettled_s)
        m_editor_state.history.note(m_editor_state.scene);
}

void App::handle_clicks() {
    if (const auto& at = m_navigator.click())
        click(at->x, at->y, at->twice);
}

void App::click(double x, double y, bool twice) {
    const auto& view = m_picture.view();
    if (!view || !m_pane.holds(x, y))
        return;
    const auto& size = view->scene.output.size_px;
    const double px = (x - m_pane.x) / m_pane.width * size[0],
                 py = (y - m_pane.y) / m_pane.height * size[1];
    if (const auto ray = view->camera.ray(px, py, 0.5, 0.5))
        m_pick.click(m_editor_state, {x, y, twice}, *ray, view);
}

void App::handle_keys() {
    const ImGuiIO& io = ImGui::GetIO();
    const auto pressed = [](int key) { return ImGui::IsKeyPressed(key, false); };
    const auto repeated = [](int key) { return ImGui::IsKeyPressed(key, true); };
    if (io.KeyCtrl) {
        if (pressed(Window::key_of('q')))
            m_window.close();
        if (Window::typing())
            return;
        if (pressed(Window::key_of('s')))
            m_files.save_scene(m_editor_state);
        if (pressed(Window::key_of('o')))
            m_files.open_scene(m_editor_state);
        if (pressed(Window::key_of('p')))
            m_files.save_picture(m_editor_state, m_picture);
        if (pressed(Window::key_of('r')))
            m_files.start_final(m_editor_state, m_final);
        if (pressed(Window::key_of('k'))) {
            m_window.copy_text(m_files.command_line(m_editor_state));
            m_editor_state.say("the command line is on the clipboard");
        }
        if (repeated(Window::key_of('z')) && !io.KeyShift)
            m_editor_state.undo();
        if (repeated(Window::key_of('y')) || (repeated(Window::key_of('z')) && io.KeyShift))
            m_editor_state.redo();
        return;
    }
    if (pressed(GLFW_KEY_F1))
        m_editor_state.shows_help = !m_editor_state.shows_help;
    if (pressed(GLFW_KEY_F2))
        m_editor_state.shows_panel = !m_editor_state.shows_panel;
    if (pressed(GLFW_KEY_F3))
        m_editor_state.shows_map = !m_editor_state.shows_map;
    if (pressed(GLFW_KEY_F4))
        m_editor_state.shows_path = !m_editor_state.shows_path;
    const auto other_layer = [this](std::size_t by) {
        const auto at = static_cast<std::size_t>(m_editor_state.layer);
        m_editor_state.layer = kLayers[(at + by) % kLayers.size()].layer;
    };
    if (pressed(GLFW_KEY_F5))
        other_layer(kLayers.size() - 1);
    if (pressed(GLFW_KEY_F6))
        other_layer(1);
    if (pressed(GLFW_KEY_F7))
        m_editor_state.light = !m_editor_state.light;
    if (pressed(GLFW_KEY_F8))
        m_editor_state.fills = !m_editor_state.fills;
    if (Window::typing())
        return;
    if (pressed(GLFW_KEY_ESCAPE)) {
        m_pick.clear();
        m_editor_state.shows_help = false;
        ImGui::SetWindowFocus(nullptr);
    }
    if (pressed(Window::key_of('f'))) {
        m_editor_state.fly = !m_editor_state.fly;
        m_editor_state.say(m_editor_state.fly ? "fly: the mouse turns your head"
                                              : "orbit: the mouse circles what you look at");
    }
    if (pressed(Window::key_of('m'))) {
        m_editor_state.measures = !m_editor_state.measures;
        m_pick.clear();
    }
    if (pressed(Window::key_of('v')))
        click(m_pane.x + m_pane.width / 2.0, m_pane.y + m_pane.height / 2.0, false);
    if (pressed(Window::key_of('k'))) {
        m_path.add_key(m_editor_state);
        m_editor_state.shows_path = true;
    }
    if (pressed(Window::key_of('p')))
        m_path.toggle(m_editor_state);
    if (pressed(GLFW_KEY_HOME) && !io.NavActive)
        m_editor_state.frame_all();
    constexpr double kQuarter_h = 0.25, kThird_ev = 1.0 / 3;
    double& time_h = m_editor_state.scene.sun.time_h;
    if (repeated(GLFW_KEY_LEFT_BRACKET))
        time_h = std::max(time_h - kQuarter_h, 0.0);
    if (repeated(GLFW_KEY_RIGHT_BRACKET))
        time_h = std::min(time_h + kQuarter_h, 24.0);
    double& exposure_ev = m_editor_state.scene.output.exposure_ev;
    if (repeated(GLFW_KEY_MINUS))
        exposure_ev = std::max(exposure_ev - kThird_ev, -20.0);
    if (repeated(GLFW_KEY_EQUAL))
        exposure_ev = std::min(exposure_ev + kThird_ev, 20.0);
}

float App::panel_px() const {
    return m_editor_state.shows_panel
               ? std::min(kPanel_ems * ImGui::GetFontSize(), static_cast<float>(m_window_px[0]))
               : 0;
}

void App::draw() {
    const auto& view = m_picture.view();
    if (m_editor_state.shows_panel)
        draw_panel();
    panels::draw_status(
        m_editor_state,
        {m_picture.status(), m_picture.busy(), m_times.frame_s(), m_probe ? m_probe->missing() : 0},
        panel_px(), static_cast<float>(m_window_px[0]));
    const float margin = ImGui::GetFontSize(),
                flight = m_path.draw(m_editor_state, panel_px(), m_window_px);
    const auto right = static_cast<float>(m_window_px[0]),
               lower = static_cast<float>(m_window_px[1]);
    m_map.draw(m_editor_state, m_pick, view,
               {right - margin, lower - margin - (flight > 0 ? flight + margin : 0)});
    if (view)
        m_pick.draw(m_editor_state, *view, m_pane, m_window_px);
    panels::draw_help(m_editor_state, m_window_px);
}

void App::draw_panel() {
    ImGui::SetNextWindowPos({0, 0});
    ImGui::SetNextWindowSize({panel_px(), static_cast<float>(m_window_px[1])});
    ImGui::Begin("Terravox", nullptr,
                 ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse |
                     ImGuiWindowFlags_NoBringToFrontOnFocus | ImGuiWindowFlags_NoFocusOnAppearing);
    if (panels::widgets::button("Undo", m_editor_state.can_undo()))
        m_editor_state.undo();
    ImGui::SameLine();
    if (panels::widgets::button("Redo", m_editor_state.can_redo()))
        m_editor_state.redo();
    ImGui::SameLine();
    if (panels::widgets::button("Flight (F4)"))
        m_editor_state.shows_path = !m_editor_state.shows_path;
    ImGui::SameLine();
    if (panels::widgets::button(m_editor_state.light ? "Dark (F7)" : "Light (F7)"))
        m_editor_state.light = !m_editor_state.light;
    ImGui::SameLine();
    if (panels::widgets::button("Help (F1)"))
        m_editor_state.shows_help = !m_editor_state.shows_help;
    scene::Scene usual = m_editor_state.opened;
    panels::SceneForm form(m_editor_state.scene, usual);
    const scene::Scene before = m_editor_state.scene;
    const auto heading = [](const char* name, bool open) {
        const bool shows = ImGui::CollapsingHeader(
            name, open ? ImGuiTreeNodeFlags_DefaultOpen : ImGuiTreeNodeFlags_None);
        panels::widgets::tell_place(name);
        return shows;
    };
    if (heading("Sun and sky", true))
        panels::draw_light(m_editor_state, form);
    if (heading("Picture", true))
        panels::draw_picture(m_editor_state, form);
    if (heading("Camera", true))
        panels::draw_camera(m_editor_state, form);
    if (heading("Places", true))
        m_places.draw(m_editor_state, m_pick, m_picture.view());
    if (heading("Materials", false))
        panels::draw_materials(form);
    if (heading("Quality", false))
        panels::draw_quality(form);
    if (heading("Tiles", false))
        panels::draw_tiles(form);
    if (heading("Processors", false))
        m_processors.draw(m_editor_state, m_render_pool);
    if (heading("Files", true))
        m_files.draw(m_editor_state, form, m_picture, m_final);
    ImGui::End();
    if (!form.problem().empty())
        m_editor_state.say(form.problem(), true);
    // What no camera can be made of is not taken.
    if (m_editor_state.scene != before) {
        try {
            (void)scene::make_camera(m_editor_state.scene, m_editor_state.info(),
                                     m_editor_state.info().framed_bounds());
        } catch (const util::Error& e) {
            m_editor_state.scene = before;
            m_editor_state.say(e.what(), true);
        }
    }
}

}  // namespace terravox::preview
