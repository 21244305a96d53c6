#pragma once

#include <string>
#include <vector>

#include "raytracer/core/animate/animation.hpp"
#include "raytracer/core/scene/scene.hpp"

namespace terravox::preview {

/// Key frames of a flight on a time line: scenes, of which only camera, sun and exposure are used.
/// It is written as the input of `terravox animate`.
class CameraPath {
public:
    struct Key {
        double time_s = 0;
        scene::Scene scene;
    };
    /// Inserts a key frame in order of time. It replaces key frames within half a frame.
    /// @param time_s at least 0
    /// @return its index
    std::size_t put(double time_s, const scene::Scene& scene);
    void remove(std::size_t key) {
        m_keys.erase(m_keys.begin() + static_cast<std::ptrdiff_t>(key));
    }
    /// Moves a key frame to another time, but not past its neighbours.
    void move(std::size_t key, double time_s);
    void clear() noexcept { m_keys.clear(); }
    [[nodiscard]] const std::vector<Key>& keys() const noexcept { return m_keys; }
    [[nodiscard]] double seconds() const noexcept {
        return m_keys.empty() ? 0 : m_keys.back().time_s;
    }

    double fps = 25;
    bool ease = true;  ///< the camera accelerates at the start and decelerates at the end

    /// The animation's file (docs/formats/animation.md).
    /// @param base fields of all frames
    [[nodiscard]] std::string to_toml(const scene::Scene& base) const;
    /// The animation, ready to be played.
    /// @throws UsageError without any key
    [[nodiscard]] animate::Animation animation(const scene::Scene& base) const {
        return animate::Animation::parse(to_toml(base), "of the camera path");
    }

private:
    std::vector<Key> m_keys;
};

}  // namespace terravox::preview
