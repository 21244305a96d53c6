#pragma once

#include <chrono>

#include "raytracer/apps/preview/scene_history.hpp"

namespace terravox::preview {

/// Adds a scene to the history once it has not changed for a while, so that a drag of the mouse is
/// one step of undo, not hundreds.
class HistoryRecorder {
public:
    using Clock = std::chrono::steady_clock;

    explicit HistoryRecorder(Clock::time_point now) : m_settled(now) {}

    /// To be called each frame.
    /// @param busy the scene is being changed by a drag, a key that is held, or a flight: nothing
    /// is added meanwhile
    void update(SceneHistory& history, const scene::Scene& scene, bool busy, Clock::time_point now);

    static constexpr std::chrono::milliseconds kSettled{400};  ///< time without a change

private:
    scene::Scene m_last;  ///< scene of the last frame
    Clock::time_point m_settled;
};

}  // namespace terravox::preview
