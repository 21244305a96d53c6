#pragma once

#include <chrono>

#include "raytracer/preview/scene_history.hpp"

namespace terravox::preview {

/// Notes a scene in the history once it has stayed the same for a while: a drag of the mouse is one
/// step of undo, not hundreds.
class HistoryRecorder {
public:
    using Clock = std::chrono::steady_clock;

    explicit HistoryRecorder(Clock::time_point now) : m_settled(now) {}

    /// To be called each frame. @param busy the scene is being changed by a drag, a key that is
    /// held, or a flight: nothing is noted meanwhile
    void update(SceneHistory& history, const scene::Scene& scene, bool busy, Clock::time_point now);

    static constexpr std::chrono::milliseconds kSettled{400};  ///< without a change

private:
    scene::Scene m_last;  ///< of the last frame
    Clock::time_point m_settled;
};

}  // namespace terravox::preview
