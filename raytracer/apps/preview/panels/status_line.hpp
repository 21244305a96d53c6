#pragma once

#include <cstddef>

#include "raytracer/apps/preview/editor_state.hpp"
#include "raytracer/apps/preview/progressive.hpp"

namespace terravox::panels {

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

}  // namespace terravox::panels
