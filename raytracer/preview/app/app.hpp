#pragma once

#include <memory>
#include <optional>
#include <string>

#include "raytracer/preview/editor_state.hpp"
#include "raytracer/preview/final_render.hpp"
#include "raytracer/preview/frame_times.hpp"
#include "raytracer/preview/hole_watch.hpp"
#include "raytracer/preview/log_tail.hpp"
#include "raytracer/preview/navigator.hpp"
#include "raytracer/preview/pane.hpp"
#include "raytracer/preview/panels/files_panel.hpp"
#include "raytracer/preview/panels/map_panel.hpp"
#include "raytracer/preview/panels/path_panel.hpp"
#include "raytracer/preview/panels/places_panel.hpp"
#include "raytracer/preview/panels/processors_panel.hpp"
#include "raytracer/preview/pick_tool.hpp"
#include "raytracer/preview/probe_processor.hpp"
#include "raytracer/preview/window.hpp"

namespace terravox::preview {

struct AppOptions {
    render::RenderPoolOptions render_pool;        ///< of the preview
    render::RenderPoolOptions final_render_pool;  ///< of final pictures
    std::string scene_file;
    bool light = false;
    std::shared_ptr<LogTail> log;  ///< what the person is told of it
};

/// The window of an open world: input, panels, picture, frame by frame. docs/adr/0020.
///
/// All of it is on the main thread, but for processors, picks and final pictures. A frame takes
/// input, draws panels, traces for what is left of a sixtieth of a second, and shows what has
/// changed.
class App {
public:
    App(Window& window, scene::Scene scene, std::shared_ptr<render::LoadedWorld> world,
        const AppOptions& options);
    ~App();

    void frame();
    [[nodiscard]] const FrameTimes& times() const noexcept { return m_times; }
    [[nodiscard]] std::size_t holes() const { return m_editor_state.world->blocks.hole_count(); }
    [[nodiscard]] std::uint64_t pictures() const noexcept { return m_pictures; }

private:
    using Clock = std::chrono::steady_clock;
    void handle_keys();
    void handle_clicks();
    void click(double x, double y, bool twice);
    void note_history();
    void draw();
    void draw_panel();
    void hear();
    void restart_if_changed(Clock::time_point now);
    void start(const scene::Scene& wanted, int first_step, Clock::time_point now);
    void work(Clock::time_point until);
    void show_changes();
    void choose_first_step();
    [[nodiscard]] scene::Scene scene_to_show() const;
    [[nodiscard]] std::shared_ptr<processors::TileProcessor> begin_picture(const shade::View& view);
    [[nodiscard]] float panel_px() const;
    [[nodiscard]] double wait_s() const;
    [[nodiscard]] bool at_rest() const;

    Window& m_window;
    EditorState m_editor_state;
    FinalRender m_final;
    render::RenderPool m_render_pool;
    std::shared_ptr<ProbeProcessor>
        m_probe;  ///< of the picture under way, where a layer of walks is shown
    Progressive m_picture;
    panels::MapPanel m_map;
    PickTool m_pick;
    HoleWatch m_holes;
    Navigator m_navigator;
    panels::FilesPanel m_files;
    panels::PathPanel m_path;
    panels::PlacesPanel m_places;
    panels::ProcessorsPanel m_processors;
    ScreenPicture m_screen;
    FrameTimes m_times;

    std::optional<scene::Scene> m_shown;  ///< that the picture is of
    Layer m_shown_layer = Layer::kBeauty;
    scene::Scene::Output m_shown_output;  ///< exposure and tone that the screen has
    scene::Scene m_last_scene;            ///< in the last frame
    std::array<int, 2> m_window_px{};
    Pane m_pane;
    int m_first_step = 8;
    int m_lively = 0;      ///< frames that follow one another, though nothing is to be done
    bool m_rests = false;  ///< after the frame before
    std::optional<Clock::time_point>
        m_changed;  ///< when what is under way was asked for; until it has been seen
    bool m_develop_all =
        false;  ///< once the picture is whole: what the screen has was developed otherwise
    Clock::time_point m_frame_began, m_started, m_settled, m_probed, m_idle_since;
    double m_probe_wait_s = 0;
    std::size_t m_probe_missing = 0;
    std::shared_ptr<LogTail> m_log;
    bool m_final_ran = false;
    bool m_world_changed = false;  ///< and the person was told
    double m_drawing_s = 0.004;    ///< of a frame, beside tracing
    std::uint64_t m_pictures = 0;
    bool m_moving = false;
    bool m_far = false;  ///< the world is a server's, or an archive elsewhere
};

}  // namespace terravox::preview
