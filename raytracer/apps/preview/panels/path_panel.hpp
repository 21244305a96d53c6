#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "raytracer/apps/preview/camera_path.hpp"
#include "raytracer/apps/preview/editor_state.hpp"

namespace terravox::panels {

/// A time line with the key frames of a flight: made, moved, played and saved.
class PathPanel {
public:
    /// Draws its window, along the lower edge next to the side panel.
    /// @return its height, pixels; 0 while it is hidden
    float draw(preview::EditorState& editor_state, float panel_px, std::array<int, 2> window_px);
    /// While the flight plays, shows the scene of the current time.
    /// @param ready whether the last scene has been shown
    void play(preview::EditorState& editor_state, bool ready);
    void add_key(preview::EditorState& editor_state);
    void toggle(preview::EditorState& editor_state);
    [[nodiscard]] bool playing() const noexcept { return m_animation.has_value(); }

private:
    void show(preview::EditorState& editor_state, double time_s);
    void save(preview::EditorState& editor_state);
    void draw_line(preview::EditorState& editor_state);
    std::optional<animate::Animation> make(preview::EditorState& editor_state) const;

    preview::CameraPath m_path;
    double m_time_s = 0;
    double m_length_s = 10;
    std::optional<std::size_t> m_chosen;
    std::string m_file = "flight.toml";
    std::optional<animate::Animation> m_animation;  ///< set while it plays
    scene::Scene m_before;                          ///< the scene before it played
    std::chrono::steady_clock::time_point m_began;
    double m_began_s = 0;
};

}  // namespace terravox::panels
