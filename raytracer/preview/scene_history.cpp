#include "raytracer/preview/scene_history.hpp"

namespace terravox {

void SceneHistory::note(const Scene& scene) {
    if (scene == m_scenes[m_at])
        return;
    m_scenes.resize(m_at + 1);
    m_scenes.push_back(scene);
    if (m_scenes.size() > kMost)
        m_scenes.erase(m_scenes.begin());
    m_at = m_scenes.size() - 1;
}

}  // namespace terravox
