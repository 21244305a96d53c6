#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "common/util/error.hpp"
#include "raytracer/apps/preview/layers.hpp"
#include "raytracer/apps/preview/viewpoint.hpp"
#include "raytracer/core/scene/scene.hpp"
#include "raytracer/farm/render/loaded_world.hpp"

namespace terravox::preview {

/// The history of a scene, for undo and redo.
class SceneHistory {
public:
    explicit SceneHistory(const scene::Scene& first) : m_scenes{first} {}
    /// Adds the scene unless it equals now(). Scenes that were undone are dropped, and the oldest
    /// one when there are more than kMax.
    void note(const scene::Scene& scene);
    /// The scene that was added last, or that undo or redo has returned to.
    [[nodiscard]] const scene::Scene& now() const noexcept { return m_scenes[m_at]; }
    [[nodiscard]] bool can_undo() const noexcept { return m_at > 0; }
    [[nodiscard]] bool can_redo() const noexcept { return m_at + 1 < m_scenes.size(); }
    /// @return the previous scene; the oldest one if there is no previous one
    const scene::Scene& undo() noexcept { return m_scenes[m_at -= can_undo() ? 1 : 0]; }
    const scene::Scene& redo() noexcept { return m_scenes[m_at += can_redo() ? 1 : 0]; }

    static constexpr std::size_t kMax = 500;

private:
    std::vector<scene::Scene> m_scenes;  ///< never empty
    std::size_t m_at = 0;
};

/// Adds a scene to the history once it has not changed for a while, so that a drag of the mouse is
/// one step of undo, not hundreds.
class HistoryRecorder {
public:
    using Clock = std::chrono::steady_clock;

    explicit HistoryRecorder(Clock::time_point now) : m_settled(now) {}

    /// To be called each frame.
    /// @param busy the scene is being changed by a drag, a key that is held, or a flight: nothing
    /// is added meanwhile
    void update(SceneHistory& history, const scene::Scene& scene, bool busy, Clock::time_point now);

    static constexpr std::chrono::milliseconds kSettled{400};  ///< time without a change

private:
    scene::Scene m_last;  ///< scene of the last frame
    Clock::time_point m_settled;
};

/// The state that the user edits in the window. Panels show and change it; the code that draws the
/// picture compares it with the last frame's. It is plain data that all panels share, and therefore
/// has more members than other classes.
struct EditorState {
    EditorState(scene::Scene first, std::shared_ptr<render::LoadedWorld> world);

    scene::Scene scene;         ///< output.size is that of the final picture; camera.look is empty
    const scene::Scene opened;  ///< the scene when the window opened, to which "reset" returns
    std::shared_ptr<render::LoadedWorld> world;
    Viewpoint viewpoint;
    SceneHistory history;

    Layer layer = Layer::kBeauty;
    double resolution = 1;  ///< ratio of the preview's pixels to the window's, along an edge
    bool fly = false;       ///< the mouse turns the camera; else the camera orbits the target
    /// The picture fills the window; else it has the final picture's aspect ratio.
    bool fills = false;
    bool measures = false;  ///< a click sets an end of the measured distance
    bool light = false;     ///< light colours of the window
    bool shows_panel = true;
    bool shows_map = true;
    bool shows_path = false;
    bool shows_help = false;

    [[nodiscard]] const voxel::WorldInfo& info() const noexcept { return world->world->info(); }
    /// Writes the viewpoint, which has changed, into the scene.
    void moved() { viewpoint.apply(scene, info()); }
    /// Replaces the scene, except for the inputs of the open world and the settings of threads and
    /// processors. Undo returns to the previous one.
    /// @throws UsageError when its camera cannot be placed; then nothing has changed
    void take(scene::Scene other);
    /// As take(), for one scene of a sequence: undo does not return to each.
    /// @throws as take()
    void show(scene::Scene other);
    /// The scene with the viewpoint written out in the world's coordinates, even if the scene has a
    /// named view or a framing.
    [[nodiscard]] scene::Scene placed() const;
    /// Moves the camera so that the picture shows the whole world.
    void frame_all();
    void undo();
    void redo();
    /// A change that is not in the history yet can be undone, too.
    [[nodiscard]] bool can_undo() const { return history.can_undo() || scene != history.now(); }
    [[nodiscard]] bool can_redo() const { return history.can_redo() && scene == history.now(); }

    /// Shows a line in the window for some seconds, and logs it.
    void notify(std::string line, bool bad = false);
    /// Does something that may fail; the error is a bad notice then.
    template <class Work>
    void attempt(const Work& work) {
        try {
            work();
        } catch (const util::Error& e) {
            notify(e.what(), true);
        }
    }
    /// Shows a line that was logged elsewhere.
    void show_logged(std::string line);
    std::string notice;
    bool notice_is_bad = false;
    std::chrono::steady_clock::time_point noticed_at;

private:
    [[nodiscard]] Viewpoint to_viewpoint(const scene::Scene& of) const;
};

}  // namespace terravox::preview
