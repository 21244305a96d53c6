#pragma once

#include <string>
#include <vector>

#include "raytracer/animate/animation.hpp"
#include "raytracer/scene/scene.hpp"

namespace terravox::preview {

/// Key frames of a flight on a time line: scenes, of which camera, sun and exposure count. What
/// `terravox animate` takes.
class CameraPath {
public:
    struct Key {
        double time_s = 0;
        scene::Scene scene;
    };
    /// In order of time; it takes the place of those within half a frame. @param time_s at least 0
    /// @return its place
    std::size_t put(double time_s, const scene::Scene& scene);
    void remove(std::size_t key) {
        m_keys.erase(m_keys.begin() + static_cast<std::ptrdiff_t>(key));
    }
    /// To another time, but not past the keys beside it.
    void move(std::size_t key, double time_s);
    void clear() noexcept { m_keys.clear(); }
    [[nodiscard]] const std::vector<Key>& keys() const noexcept { return m_keys; }
    [[nodiscard]] double seconds() const noexcept {
        return m_keys.empty() ? 0 : m_keys.back().time_s;
    }

    double fps = 25;
    bool ease = true;  ///< it begins and ends at rest

    /// The animation's file (docs/formats/animation.md). @param base fields of all frames
    [[nodiscard]] std::string to_toml(const scene::Scene& base) const;
    /// Ready to be played. @throws UsageError with less than one key
    [[nodiscard]] animate::Animation animation(const scene::Scene& base) const {
        return animate::Animation::parse(to_toml(base), "of the camera path");
    }

private:
    std::vector<Key> m_keys;
};

}  // namespace terravox::preview
