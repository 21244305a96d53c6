#pragma once

#include "raytracer/apps/preview/layers.hpp"
#include "raytracer/apps/preview/progressive.hpp"

namespace terravox::preview {

/// Rows of a picture, half-open; empty where first >= end.
struct RowRange {
    int first = 0;
    int end = 0;
    [[nodiscard]] bool empty() const noexcept { return first >= end; }
};

/// Develops a progressive picture for the window: tiles that are new in the film, or the whole film
/// when exposure, tone or layer have changed. Used by one thread.
class ScreenDeveloper {
public:
    /// To be called when a new picture begins; the screen stays until its tiles replace it.
    void begin_picture() noexcept { m_develops_all = false; }
    /// Sets the size of the picture in progress. The screen is cleared if the size differs.
    void resize(int width_px, int height_px) { m_screen.resize(width_px, height_px); }
    /// To be called when another layer of the same film is shown.
    void develop_again() noexcept { m_develops_all = true; }

    /// @param output exposure and tone
    /// @return the rows of the screen that have changed
    [[nodiscard]] RowRange update(Progressive& picture, const scene::Scene::Output& output,
                                  Layer layer);
    [[nodiscard]] const ScreenPicture& screen() const noexcept { return m_screen; }

private:
    ScreenPicture m_screen;
    scene::Scene::Output m_output;  ///< exposure and tone of the screen
    /// The screen was developed with other settings. It is developed again once the picture is
    /// whole, so that no pixels of the previous picture reappear.
    bool m_develops_all = false;
};

}  // namespace terravox::preview
