#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "raytracer/preview/layers.hpp"
#include "raytracer/preview/scene_history.hpp"
#include "raytracer/preview/viewpoint.hpp"
#include "raytracer/render/loaded_world.hpp"
#include "raytracer/scene/scene.hpp"

namespace terravox::preview {

/// All that a person at the window works with. Panels show and change it; whoever draws the picture
/// sees what is different. Plain data that all panels share, and therefore more of it than a class
/// has elsewhere.
struct EditorState {
    EditorState(scene::Scene first, std::shared_ptr<render::LoadedWorld> world);

    scene::Scene scene;         ///< output.size is that of the final picture; camera.look is empty
    const scene::Scene opened;  ///< as it was when the window opened: what "reset" goes back to
    std::shared_ptr<render::LoadedWorld> world;
    Viewpoint viewpoint;
    SceneHistory history;

    Layer layer = Layer::kBeauty;
    double resolution = 1;  ///< pixels of the preview to pixels of the window, along an edge
    bool fly = false;       ///< the mouse turns the head; else it circles the target
    bool fills = false;  ///< the picture fills the window; else it has the shape of the final one
    bool measures = false;  ///< a click is an end of what is measured
    bool light = false, shows_panel = true, shows_map = true, shows_path = false,
         shows_help = false;

    [[nodiscard]] const voxel::WorldInfo& info() const noexcept { return world->world->info(); }
    /// The viewpoint has changed: into the scene with it.
    void moved() { viewpoint.apply(scene, info()); }
    /// Another scene altogether, but for what the open world was made of, and who renders. What was
    /// there before can be come back to.
    /// @throws UsageError when no camera can be placed by it; then nothing has changed
    void take(scene::Scene other);
    /// The same, as one of many that follow one another: there is no way back to each. @throws as
    /// take()
    void show(scene::Scene other);
    /// The scene with the viewpoint written out in the world's own coordinates, wherever it comes
    /// from.
    [[nodiscard]] scene::Scene placed() const;
    /// The whole world in the picture.
    void frame_all();
    void undo();
    void redo();
    /// What has not been noted yet can be undone, too.
    [[nodiscard]] bool can_undo() const { return history.can_undo() || scene != history.now(); }
    [[nodiscard]] bool can_redo() const { return history.can_redo() && scene == history.now(); }

    /// A line for the person, for some seconds, and for the log.
    void say(std::string line, bool bad = false);
    /// What somebody else has written to the log.
    void heard(std::string line);
    std::string said;
    bool said_bad = false;
    std::chrono::steady_clock::time_point said_at;

private:
    [[nodiscard]] Viewpoint viewpoint_of(const scene::Scene& of) const;
};

}  // namespace terravox::preview
