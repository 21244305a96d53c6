#pragma once

#include <array>

#include "raytracer/preview/editor_state.hpp"

namespace terravox::panels {

/// What keys and mouse do; closes itself.
void draw_help(preview::EditorState& editor_state, std::array<int, 2> window_px);

}  // namespace terravox::panels
