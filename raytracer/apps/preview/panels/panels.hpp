#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "raytracer/apps/preview/camera_path.hpp"
#include "raytracer/apps/preview/editor_state.hpp"
#include "raytracer/apps/preview/final_render.hpp"
#include "raytracer/apps/preview/mini_map.hpp"
#include "raytracer/apps/preview/panels/form.hpp"
#include "raytracer/apps/preview/pick_tool.hpp"
#include "raytracer/apps/preview/progressive.hpp"
#include "raytracer/apps/preview/window.hpp"
#include "raytracer/core/scene/views.hpp"
#include "raytracer/farm/render/render_pool.hpp"

namespace terravox::panels {

class SceneForm;

/// Saves and opens scenes, saves pictures, and starts the final picture.
class FilesPanel {
public:
    /// @param scene_file file name that is offered at first
    /// @param render_pool options for final pictures
    FilesPanel(std::string scene_file, render::RenderPoolOptions render_pool)
        : m_scene_file(std::move(scene_file)), m_render_pool(std::move(render_pool)) {}

    void draw(preview::EditorState& editor_state, SceneForm& form,
              const preview::Progressive& picture, preview::FinalRender& final_render);
    void save_scene(preview::EditorState& editor_state) const;
    void open_scene(preview::EditorState& editor_state) { open_scene(editor_state, m_scene_file); }
    void open_scene(preview::EditorState& editor_state, const std::string& file);
    void save_picture(preview::EditorState& editor_state,
                      const preview::Progressive& picture) const;
    void start_final(preview::EditorState& editor_state, preview::FinalRender& final_render) const;
    [[nodiscard]] std::string command_line(const preview::EditorState& editor_state) const;

private:
    std::string m_scene_file;
    std::string m_picture_file = "preview.png";
    std::string m_final_files = "picture.png";
    const render::RenderPoolOptions m_render_pool;
};

/// The map in a corner of the window: camera position, target and angle of view; a click moves the
/// viewpoint there.
class MapPanel {
public:
    /// If no map can be made of the world, a notice is shown, and draw() draws nothing.
    /// @param edge_px of the longer side
    MapPanel(preview::EditorState& editor_state, int edge_px);

    [[nodiscard]] bool busy() const noexcept { return m_map && m_map->busy(); }
    /// Renders the map again, as boxes that were holes may be available now.
    void begin_again() {
        if (m_map)
            m_map->begin();
    }
    /// Continues the map until then.
    /// @throws Error
    void work(preview::Progressive::Clock::time_point until) { m_map->work(until); }
    /// @param view of the picture that is shown
    /// @param corner lower right corner of the map, pixels
    void draw(preview::EditorState& editor_state, preview::PickTool& tool,
              const std::shared_ptr<const shade::View>& view, std::array<float, 2> corner);

private:
    /// Draws the eye, the target and the angle of view.
    /// @param corner, extent upper left corner and size of the map, pixels
    void draw_view(const preview::EditorState& editor_state, const shade::View* view,
                   std::array<float, 2> corner, std::array<float, 2> extent) const;

    std::unique_ptr<preview::MiniMap> m_map;
    std::uint64_t m_version = 0;  ///< version of the map that the texture shows
    preview::Texture m_texture;
};

/// A time line with the key frames of a flight: made, moved, played and saved.
class PathPanel {
public:
    /// Draws its window, along the lower edge next to the side panel.
    /// @return its height, pixels; 0 while it is hidden
    float draw(preview::EditorState& editor_state, float panel_px, std::array<int, 2> window_px);
    /// While the flight plays, shows the scene of the current time.
    /// @param ready whether the last scene has been shown
    void play(preview::EditorState& editor_state, bool ready);
    void add_key(preview::EditorState& editor_state);
    void toggle(preview::EditorState& editor_state);
    [[nodiscard]] bool playing() const noexcept { return m_animation.has_value(); }

private:
    void show(preview::EditorState& editor_state, double time_s);
    void save(preview::EditorState& editor_state);
    void draw_line(preview::EditorState& editor_state);
    std::optional<animate::Animation> make(preview::EditorState& editor_state) const;

    preview::CameraPath m_path;
    double m_time_s = 0;
    double m_length_s = 10;
    std::optional<std::size_t> m_chosen;
    std::string m_file = "flight.toml";
    std::optional<animate::Animation> m_animation;  ///< set while it plays
    scene::Scene m_before;                          ///< the scene before it played
    std::chrono::steady_clock::time_point m_began;
    double m_began_s = 0;
};

/// Moves the viewpoint to named views and to coordinates.
class PlacesPanel {
public:
    /// @param view of the picture that is shown
    void draw(preview::EditorState& editor_state, preview::PickTool& tool,
              const std::shared_ptr<const shade::View>& view);

private:
    /// Named views in this world; read when they are first shown.
    std::optional<std::vector<scene::NamedView>> m_views;
    std::string m_place;
};

/// Parses "lat, lon" or "easting, northing", distinguished by magnitude.
/// @return level-0 voxels x, z
/// @throws UsageError for other text, and for a place outside the world's CRS
[[nodiscard]] std::array<double, 2> parse_place(const std::string& text,
                                                const voxel::WorldInfo& world);

/// The processors that render the preview: shows their state, adds and removes them.
class ProcessorsPanel {
public:
    void draw(preview::EditorState& editor_state, render::RenderPool& render_pool);

private:
    struct Speed {
        std::uint64_t tiles = 0;  ///< at the last update
        double tiles_per_s = 0;   ///< moving average
    };
    void update(const render::RenderPool& render_pool);
    void note_speeds(double passed_s);
    void draw_local(render::RenderPool& render_pool) const;
    void draw_workers(preview::EditorState& editor_state, render::RenderPool& render_pool);
    void draw_participants();
    std::string m_address;
    std::vector<render::RenderPool::Participant> m_participants;
    std::map<processors::ProcessorPool::MemberId, Speed> m_speeds;
    std::vector<std::string> m_dialled;
    std::chrono::steady_clock::time_point m_updated;
};

}  // namespace terravox::panels

/// Parts of the panel that show fields of the scene. Each draws between two headings.
namespace terravox::panels {

void draw_light(preview::EditorState& editor_state, SceneForm& form);    ///< sun and sky
void draw_picture(preview::EditorState& editor_state, SceneForm& form);  ///< exposure, tone, layer
void draw_camera(preview::EditorState& editor_state, SceneForm& form);
void draw_materials(SceneForm& form);
void draw_quality(SceneForm& form);  ///< integrator, samples, detail
void draw_tiles(SceneForm& form);

struct StatusFacts {
    preview::Progressive::Status picture;
    bool busy = false;
    double frame_s = 0;       ///< 0: unknown
    std::size_t missing = 0;  ///< boxes that a probe layer lacks (LivePicture::missing)
};

/// Draws the picture's progress and the current notice, in the upper left corner next to the side
/// panel.
/// @param left_px of that corner
/// @param width_px of the window
void draw_status(const preview::EditorState& editor_state, const StatusFacts& facts, float left_px,
                 float width_px);

/// Draws the window that explains keys and mouse, while it is open.
void draw_help(preview::EditorState& editor_state, std::array<int, 2> window_px);

}  // namespace terravox::panels
