#pragma once

#include <cstddef>
#include <vector>

#include "raytracer/scene/scene.hpp"

namespace terravox::preview {

/// What a scene was, for undo and redo.
class SceneHistory {
public:
    explicit SceneHistory(const scene::Scene& first) : m_scenes{first} {}
    /// The scene is like this now. What was undone is forgotten; nothing happens where it is the
    /// same. The oldest goes when there are too many.
    void note(const scene::Scene& scene);
    [[nodiscard]] const scene::Scene& now() const noexcept {
        return m_scenes[m_at];
    }  ///< as noted, or gone back to
    [[nodiscard]] bool can_undo() const noexcept { return m_at > 0; }
    [[nodiscard]] bool can_redo() const noexcept { return m_at + 1 < m_scenes.size(); }
    /// @return the scene as it was; the oldest there is when there is none before
    const scene::Scene& undo() noexcept { return m_scenes[m_at -= can_undo() ? 1 : 0]; }
    const scene::Scene& redo() noexcept { return m_scenes[m_at += can_redo() ? 1 : 0]; }

    static constexpr std::size_t kMax = 500;

private:
    std::vector<scene::Scene> m_scenes;  ///< never empty
    std::size_t m_at = 0;
};

}  // namespace terravox::preview
