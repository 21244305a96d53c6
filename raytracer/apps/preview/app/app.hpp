#pragma once

#include <array>
#include <memory>
#include <string>

#include "raytracer/apps/preview/app/side_panel.hpp"
#include "raytracer/apps/preview/editor_state.hpp"
#include "raytracer/apps/preview/final_render.hpp"
#include "raytracer/apps/preview/frame_pacer.hpp"
#include "raytracer/apps/preview/frame_times.hpp"
#include "raytracer/apps/preview/history_recorder.hpp"
#include "raytracer/apps/preview/live_picture.hpp"
#include "raytracer/apps/preview/navigator.hpp"
#include "raytracer/apps/preview/notices.hpp"
#include "raytracer/apps/preview/pane.hpp"
#include "raytracer/apps/preview/panels/map_panel.hpp"
#include "raytracer/apps/preview/panels/path_panel.hpp"
#include "raytracer/apps/preview/pick_tool.hpp"
#include "raytracer/apps/preview/window.hpp"

namespace terravox::preview {

struct AppOptions {
    render::RenderPoolOptions render_pool;        ///< of the preview
    render::RenderPoolOptions final_render_pool;  ///< of final pictures
    std::string scene_file;
    bool light = false;
    std::shared_ptr<LogTail> log;  ///< its warnings are shown in the window
};

/// The window of an open world: input, panels, picture, frame by frame. docs/adr/0020.
///
/// It only connects its parts. All of it is on the main thread, except for processors, picks and
/// final pictures. A frame takes input, draws panels, traces for the rest of a sixtieth of a
/// second, and shows what has changed.
class App {
public:
    App(Window& window, scene::Scene scene, std::shared_ptr<render::LoadedWorld> world,
        const AppOptions& options);
    ~App();

    void frame();
    [[nodiscard]] const FrameTimes& times() const noexcept { return m_times; }
    [[nodiscard]] std::size_t holes() const { return m_editor_state.world->blocks.hole_count(); }
    [[nodiscard]] std::uint64_t pictures() const noexcept { return m_picture.started_count(); }

private:
    using Clock = std::chrono::steady_clock;
    [[nodiscard]] Activity activity() const;
    /// @return seconds since the last frame, at most a tenth
    [[nodiscard]] double wait_for_input();
    void lay_out();
    void show_notices();
    void handle_input(double passed_s);
    void draw();
    void note_history();
    void update_picture();
    void work(Clock::time_point until);
    void show_picture();
    void note_rest();

    Window& m_window;
    EditorState m_editor_state;
    FrameTimes m_times;
    FinalRender m_final;
    LivePicture m_picture;
    panels::MapPanel m_map;
    PickTool m_pick;
    Navigator m_navigator;
    SidePanel m_side_panel;
    panels::PathPanel m_path;
    Notices m_notices;
    FramePacer m_pacer;
    HistoryRecorder m_history_recorder;
    std::array<int, 2> m_window_px{};  ///< as it last was, while it is minimized
    Pane m_pane;
};

}  // namespace terravox::preview
