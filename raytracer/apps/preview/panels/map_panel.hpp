#pragma once

#include <array>
#include <memory>

#include "raytracer/apps/preview/editor_state.hpp"
#include "raytracer/apps/preview/mini_map.hpp"
#include "raytracer/apps/preview/pick_tool.hpp"
#include "raytracer/apps/preview/window.hpp"

namespace terravox::panels {

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

}  // namespace terravox::panels
