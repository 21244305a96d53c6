#pragma once

#include <cstddef>
#include <vector>

#include "raytracer/core/scene/scene.hpp"

namespace terravox::preview {

/// The history of a scene, for undo and redo.
class SceneHistory {
public:
    explicit SceneHistory(const scene::Scene& first) : m_scenes{first} {}
    /// Adds the scene unless it equals now(). Scenes that were undone are dropped, and the oldest
    /// one when there are more than kMax.
    void note(const scene::Scene& scene);
    /// The scene that was added last, or that undo or redo has returned to.
    [[nodiscard]] const scene::Scene& now() const noexcept { return m_scenes[m_at]; }
    [[nodiscard]] bool can_undo() const noexcept { return m_at > 0; }
    [[nodiscard]] bool can_redo() const noexcept { return m_at + 1 < m_scenes.size(); }
    /// @return the previous scene; the oldest one if there is no previous one
    const scene::Scene& undo() noexcept { return m_scenes[m_at -= can_undo() ? 1 : 0]; }
    const scene::Scene& redo() noexcept { return m_scenes[m_at += can_redo() ? 1 : 0]; }

    static constexpr std::size_t kMax = 500;

private:
    std::vector<scene::Scene> m_scenes;  ///< never empty
    std::size_t m_at = 0;
};

}  // namespace terravox::preview
