#pragma once

#include <array>
#include <memory>
#include <string>

#include "raytracer/apps/preview/editor_state.hpp"
#include "raytracer/apps/preview/final_render.hpp"
#include "raytracer/apps/preview/frame_pacer.hpp"
#include "raytracer/apps/preview/live_picture.hpp"
#include "raytracer/apps/preview/navigator.hpp"
#include "raytracer/apps/preview/notices.hpp"
#include "raytracer/apps/preview/opening.hpp"
#include "raytracer/apps/preview/pane.hpp"
#include "raytracer/apps/preview/panels/form.hpp"
#include "raytracer/apps/preview/panels/panels.hpp"
#include "raytracer/apps/preview/pick_tool.hpp"
#include "raytracer/apps/preview/window.hpp"

namespace terravox::preview {

/// The panel at the left edge of the window: the fields of the scene, places, processors and files,
/// each below a heading. Main thread only.
class SidePanel {
public:
    explicit SidePanel(panels::FilesPanel files) : m_files(std::move(files)) {}

    /// Draws nothing while the panel is hidden. A change after which no camera can be placed is
    /// refused.
    void draw(EditorState& editor_state, PickTool& pick, LivePicture& picture,
              FinalRender& final_render, std::array<int, 2> window_px);
    /// @return pixels that the panel takes from the window; 0 while it is hidden
    [[nodiscard]] static float width_px(const EditorState& editor_state,
                                        std::array<int, 2> window_px);
    [[nodiscard]] panels::FilesPanel& files() noexcept { return m_files; }

private:
    void draw_sections(EditorState& editor_state, panels::SceneForm& form, PickTool& pick,
                       LivePicture& picture, FinalRender& final_render);

    panels::FilesPanel m_files;
    panels::PlacesPanel m_places;
    panels::ProcessorsPanel m_processors;
};

/// The objects that keys act on.
struct ShortcutTargets {
    Window& window;
    EditorState& editor_state;
    const Progressive& picture;
    FinalRender& final_render;
    panels::FilesPanel& files;
    panels::PathPanel& path;
    PickTool& pick;
    Pane pane;  ///< of the picture
};

/// Executes the commands of the keys of this frame, except for those that move the viewpoint
/// (Navigator). To be called after Dear ImGui has begun the frame; main thread only.
void handle_shortcuts(const ShortcutTargets& on);

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

/// Controls what the window shows from its first frame to its last: the progress of opening a
/// world, the reason if that fails, and then the world. Main thread only.
class Session {
public:
    /// Opening begins at once. @param window outlives the session
    Session(Window& window, worlds::WorldOptions from, scene::Scene scene, AppOptions options);

    void frame();
    /// @return nullptr until the world is open
    [[nodiscard]] const App* app() const noexcept { return m_app.get(); }
    /// @return why the world could not be opened or shown; empty: it is open, or being opened
    [[nodiscard]] const std::string& failure() const noexcept { return m_failure; }
    [[nodiscard]] bool is_opening() const { return m_opening->runs(); }
    /// Ends what is in progress in an open world, and closes that.
    void close() noexcept { m_app.reset(); }

private:
    [[nodiscard]] bool draw_opening();
    void take_world();
    void open();

    Window& m_window;
    const worlds::WorldOptions m_from;
    const scene::Scene m_scene;
    const AppOptions m_options;
    std::unique_ptr<Opening> m_opening;  ///< never nullptr
    std::unique_ptr<App> m_app;
    std::string m_failure;
};

}  // namespace terravox::preview
