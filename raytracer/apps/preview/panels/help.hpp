#pragma once

#include <array>

#include "raytracer/apps/preview/editor_state.hpp"

namespace terravox::panels {

/// Draws the window that explains keys and mouse, while it is open.
void draw_help(preview::EditorState& editor_state, std::array<int, 2> window_px);

}  // namespace terravox::panels
