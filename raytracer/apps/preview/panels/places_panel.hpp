#pragma once

#include <optional>
#include <string>
#include <vector>

#include "raytracer/apps/preview/pick_tool.hpp"
#include "raytracer/core/scene/views.hpp"

namespace terravox::panels {

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

}  // namespace terravox::panels
