#pragma once

#include <array>
#include <optional>

#include "raytracer/apps/preview/editor_state.hpp"
#include "raytracer/apps/preview/navigator.hpp"
#include "raytracer/apps/preview/pane.hpp"
#include "raytracer/apps/preview/picker.hpp"

namespace terravox::preview {

/// A distance between two voxels.
struct Measured {
    double level_m = 0;   ///< horizontal distance
    double height_m = 0;  ///< of the second voxel minus that of the first
    double length_m = 0;  ///< straight-line distance
    double heading_deg = 0;
};
[[nodiscard]] Measured measure(const Picked& from, const Picked& to, double voxel_m) noexcept;

/// The ray through a point of the window.
/// @param x, y pixels of the window
/// @return nullopt outside the pane, and where the camera shows nothing
[[nodiscard]] std::optional<core::Ray> ray_through(const scene::Camera& camera,
                                                   std::array<int, 2> picture_px, const Pane& pane,
                                                   double x, double y) noexcept;

/// Handles clicks on the picture: inspect a voxel, aim the camera at it, measure between two.
class PickTool {
public:
    explicit PickTool(blocks::BlockManager& blocks) : m_picker(blocks) {}

    /// @param pane that shows the picture
    /// @param view of the picture that is shown; nullptr: there is none yet
    void click(const EditorState& editor_state, const Navigator::Click& click, const Pane& pane,
               const std::shared_ptr<const shade::View>& view);
    /// Finds the ground at a point of the map, and moves the viewpoint there in update().
    /// @param x, z level-0 voxels
    void go(const EditorState& editor_state, double x, double z,
            const std::shared_ptr<const shade::View>& view);
    /// Handles the results of clicks.
    /// @return whether the viewpoint has moved
    bool update(EditorState& editor_state);
    [[nodiscard]] bool busy() const { return m_picker.busy(); }
    void clear() noexcept {
        m_read.reset();
        m_first.reset();
        m_second.reset();
    }
    /// Draws its window, and marks over the picture.
    void draw(EditorState& editor_state, const shade::View& view, const Pane& pane,
              std::array<int, 2> window_px);

private:
    void draw_marks(const shade::View& view, const Pane& pane) const;
    void draw_distance(const voxel::WorldInfo& world) const;
    void draw_facts(EditorState& editor_state) const;

    Picker m_picker;
    std::optional<Picked> m_read;
    std::optional<Picked> m_first;
    std::optional<Picked> m_second;
    std::vector<PickedFact> m_facts;  ///< facts of m_read
    core::Vec3 m_go;                  ///< target of go(), where there may be no ground
};

}  // namespace terravox::preview
