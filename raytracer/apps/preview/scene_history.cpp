#include "raytracer/apps/preview/scene_history.hpp"

namespace terravox::preview {

void SceneHistory::note(const scene::Scene& scene) {
    if (scene == m_scenes[m_at])
        return;
    m_scenes.resize(m_at + 1);
    m_scenes.push_back(scene);
    if (m_scenes.size() > kMax)
        m_scenes.erase(m_scenes.begin());
    m_at = m_scenes.size() - 1;
}

}  // namespace terravox::preview
