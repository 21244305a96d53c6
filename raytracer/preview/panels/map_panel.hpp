#pragma once

#include <array>
#include <memory>

#include "raytracer/preview/editor_state.hpp"
#include "raytracer/preview/mini_map.hpp"
#include "raytracer/preview/pick_tool.hpp"
#include "raytracer/preview/window.hpp"

namespace terravox::panels {

/// The map in a corner of the window: where one stands, what one looks at and how wide; a click
/// goes there.
class MapPanel {
public:
    /// Of a world that no map can be made of it says so; then nothing is drawn. @param edge_px of
    /// the longer side
    MapPanel(preview::EditorState& editor_state, int edge_px);

    [[nodiscard]] bool busy() const noexcept { return m_map && m_map->busy(); }
    /// Boxes that were holes may be there now.
    void begin_again() {
        if (m_map)
            m_map->begin();
    }
    /// Goes on with the map until then. @throws Error
    void work(preview::Progressive::Clock::time_point until) { m_map->work(until); }
    /// @param view of the picture that is seen @param corner its lower right one, pixels
    void draw(preview::EditorState& editor_state, preview::PickTool& tool,
              const std::shared_ptr<const shade::View>& view, std::array<float, 2> corner);

private:
    /// The eye, the target and the angle of view. @param corner, extent its upper left corner and
    /// its size, pixels
    void draw_view(const preview::EditorState& editor_state, const shade::View* view,
                   std::array<float, 2> corner, std::array<float, 2> extent) const;

    std::unique_ptr<preview::MiniMap> m_map;
    std::uint64_t m_version = 0;  ///< of the map that the texture shows
    preview::Texture m_texture;
};

}  // namespace terravox::panels
