#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace terravox::preview {

/// The part of the window that the picture is shown in, pixels; y down.
struct Pane {
    int x = 0;
    int y = 0;
    int width = 0;
    int height = 0;

    bool operator==(const Pane&) const = default;
    [[nodiscard]] bool holds(double px, double py) const noexcept {
        return px >= x && py >= y && px < x + width && py < y + height;
    }
};

/// The largest pane of an aspect ratio that fits next to the panel, centred; at least one pixel
/// wide and high.
/// @param shape width and height, of which only the ratio is used; {0, 0}: any, so that the pane
/// fills the space
[[nodiscard]] inline Pane pane_in(std::array<int, 2> window_px, int panel_px,
                                  std::array<int, 2> shape) noexcept {
    const int left = std::clamp(panel_px, 0, std::max(window_px[0] - 1, 0));
    const int width = std::max(window_px[0] - left, 1);
    const int height = std::max(window_px[1], 1);
    if (shape[0] == 0 || shape[1] == 0)
        return {left, 0, width, height};
    const double scale =
        std::min(static_cast<double>(width) / shape[0], static_cast<double>(height) / shape[1]);
    const auto fitted = [scale](int edge, int max) {
        return std::clamp(static_cast<int>(std::lround(edge * scale)), 1, max);
    };
    const int w = fitted(shape[0], width);
    const int h = fitted(shape[1], height);
    return {left + (width - w) / 2, (height - h) / 2, w, h};
}

}  // namespace terravox::preview
