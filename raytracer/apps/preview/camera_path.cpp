#include "raytracer/apps/preview/camera_path.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <sstream>
#include <string_view>

#include "raytracer/core/scene/scene_io.hpp"

namespace terravox::preview {
namespace {

/// The fields that are interpolated between keys where they differ; the camera's position always
/// is.
constexpr std::array<std::string_view, 12> kMovingFields{
    "camera.fov_deg",  "camera.height_m",    "camera.aperture_m", "camera.focus_m",
    "camera.roll_deg", "camera.azimuth_deg", "sun.time_h",        "sun.altitude_deg",
    "sun.azimuth_deg", "sky.turbidity",      "sky.clouds",        "output.exposure_ev"};

bool is_place(std::string_view path) {
    return path == "camera.position" || path == "camera.target";
}

/// A field's value as TOML: a list for what the command line writes "a,b,c".
std::string find_value(const scene::FieldText& field) {
    return is_place(field.path) ? "[" + *field.text + "]" : *field.text;
}

}  // namespace

std::size_t CameraPath::put(double time_s, const scene::Scene& scene) {
    const double frame_s = 1 / fps;
    const double at_s = std::max(time_s, 0.0);
    std::erase_if(m_keys, [&](const Key& k) { return std::abs(k.time_s - at_s) < frame_s / 2; });
    const auto later = std::upper_bound(m_keys.begin(), m_keys.end(), at_s,
                                        [](double t, const Key& k) { return t < k.time_s; });
    const auto there = m_keys.insert(later, Key{at_s, scene});
    return static_cast<std::size_t>(there - m_keys.begin());
}

void CameraPath::move(std::size_t key, double time_s) {
    const double frame_s = 1 / fps;
    const double from_s = key > 0 ? m_keys[key - 1].time_s + frame_s : 0;
    const double to_s = key + 1 < m_keys.size() ? m_keys[key + 1].time_s - frame_s : time_s;
    if (from_s <= to_s || key + 1 == m_keys.size())
        m_keys[key].time_s = std::clamp(time_s, from_s, std::max(from_s, to_s));
}

std::string CameraPath::to_toml(const scene::Scene& base) const {
    std::set<std::string> moving;
    for (const Key& key : m_keys)
        for (const scene::FieldText& field : scene::changed_fields(key.scene, m_keys.front().scene))
            if (std::find(kMovingFields.begin(), kMovingFields.end(), field.path) !=
                kMovingFields.end())
                moving.insert(field.path);
    // A field that some keys leave at the default cannot be interpolated.
    for (const Key& key : m_keys)
        for (const scene::FieldText& field : scene::field_texts(key.scene))
            if (!field.text)
                moving.erase(field.path);
    scene::Scene shared = base;
    shared.camera.look.clear();
    if (!m_keys.empty())
        shared.camera.space = m_keys.front().scene.camera.space;
    std::ostringstream out;
    out << "fps = " << fps << "\nease = " << (ease ? "true" : "false") << "\n"
        << terravox::scene::to_toml(shared);
    for (const Key& key : m_keys) {
        out << "\n[[key]]\ntime_s = " << key.time_s << "\n";
        for (const scene::FieldText& field : scene::field_texts(key.scene))
            if (field.text && (is_place(field.path) || moving.contains(field.path)))
                out << field.path << " = " << find_value(field) << "\n";
    }
    return out.str();
}

}  // namespace terravox::preview
