#pragma once

#include <array>

#include "raytracer/preview/desk.hpp"

namespace terravox::panels {

/// What keys and mouse do; closes itself.
void draw_help(Desk& desk, std::array<int, 2> window_px);

}  // namespace terravox::panels
