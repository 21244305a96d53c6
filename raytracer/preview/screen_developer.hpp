#pragma once

#include "raytracer/preview/layers.hpp"
#include "raytracer/preview/progressive.hpp"

namespace terravox::preview {

/// Rows of a picture, half-open; empty where first >= end.
struct RowRange {
    int first = 0, end = 0;
    [[nodiscard]] bool empty() const noexcept { return first >= end; }
};

/// Develops a progressive picture for the window: tiles that are new in the film, or the whole film
/// when exposure, tone or layer have changed. Used by one thread.
class ScreenDeveloper {
public:
    /// Another picture is in progress; what is seen stays until its tiles take its place.
    void begin_picture() noexcept { m_develops_all = false; }
    /// Of the picture in progress. What is seen goes where the size is another.
    void resize(int width_px, int height_px) { m_screen.resize(width_px, height_px); }
    /// Another layer of the same film is to be shown.
    void develop_again() noexcept { m_develops_all = true; }

    /// @param output exposure and tone @return the rows in which the screen has changed
    [[nodiscard]] RowRange update(Progressive& picture, const scene::Scene::Output& output,
                                  Layer layer);
    [[nodiscard]] const ScreenPicture& screen() const noexcept { return m_screen; }

private:
    ScreenPicture m_screen;
    scene::Scene::Output m_output;  ///< exposure and tone that the screen has
    /// What the screen has was developed otherwise. It is done again once the picture is whole, so
    /// that no pixels of the picture before come back.
    bool m_develops_all = false;
};

}  // namespace terravox::preview
