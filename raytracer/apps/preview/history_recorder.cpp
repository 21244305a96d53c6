#include "raytracer/apps/preview/history_recorder.hpp"

namespace terravox::preview {

void HistoryRecorder::update(SceneHistory& history, const scene::Scene& scene, bool busy,
                             Clock::time_point now) {
    if (busy || m_last != scene) {
        m_settled = now;
        m_last = scene;
    }
    if (!busy && now - m_settled > kSettled)
        history.note(scene);
}

}  // namespace terravox::preview
