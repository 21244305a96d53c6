#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "raytracer/apps/preview/layers.hpp"
#include "raytracer/apps/preview/scene_history.hpp"
#include "raytracer/apps/preview/viewpoint.hpp"
#include "raytracer/core/scene/scene.hpp"
#include "raytracer/farm/render/loaded_world.hpp"

namespace terravox::preview {

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
    /// Shows a line that was logged elsewhere.
    void show_logged(std::string line);
    std::string notice;
    bool notice_is_bad = false;
    std::chrono::steady_clock::time_point noticed_at;

private:
    [[nodiscard]] Viewpoint viewpoint_of(const scene::Scene& of) const;
};

}  // namespace terravox::preview
