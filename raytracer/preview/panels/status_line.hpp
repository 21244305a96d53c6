#pragma once

#include <cstddef>

#include "raytracer/preview/editor_state.hpp"
#include "raytracer/preview/progressive.hpp"

namespace terravox::panels {

struct StatusFacts {
    preview::Progressive::Status picture;
    bool busy = false;
    double frame_s = 0;       ///< 0: not known yet
    std::size_t missing = 0;  ///< boxes that a layer of walks would show
};

/// How far the picture is, and what is said to the person, in the upper left corner beside the
/// panel.
/// @param left_px of that corner @param width_px of the window
void draw_status(const preview::EditorState& editor_state, const StatusFacts& facts, float left_px,
                 float width_px);

}  // namespace terravox::panels
