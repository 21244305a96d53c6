#pragma once

#include <optional>
#include <string>
#include <vector>

#include "raytracer/preview/pick_tool.hpp"
#include "raytracer/scene/views.hpp"

namespace terravox::panels {

/// Where to go: named views, and coordinates.
class PlacesPanel {
public:
    /// @param view of the picture that is seen
    void draw(preview::EditorState& editor_state, preview::PickTool& tool,
              const std::shared_ptr<const shade::View>& view);

private:
    std::optional<std::vector<scene::NamedView>>
        m_views;  ///< those that lie in this world; read when they are first shown
    std::string m_place;
};

/// A place on the map out of "lat, lon" or "easting, northing", by size; level-0 voxels x, z.
/// @throws UsageError for other text, and a place that the world's CRS cannot tell
[[nodiscard]] std::array<double, 2> parse_place(const std::string& text,
                                                const voxel::WorldInfo& world);

}  // namespace terravox::panels
