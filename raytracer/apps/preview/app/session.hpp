#pragma once

#include <memory>
#include <string>

#include "raytracer/apps/preview/app/app.hpp"
#include "raytracer/apps/preview/opening.hpp"

namespace terravox::preview {

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
