#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "raytracer/scene/scene.hpp"

namespace terravox {

inline constexpr int kSceneVersion = 1;

/// Reads a scene file over `scene`: fields that the file does not name stay as they are.
/// @throws UsageError naming file, field, value and allowed range, for unknown fields too
void read_scene(const std::filesystem::path& file, Scene& scene);

/// The same of a text that came another way. @param name for messages
void parse_scene(const std::string& text, const std::string& name, Scene& scene);

/// Sets one field from text, as on the command line. @param path "section.field"
/// @throws UsageError naming field, value and allowed range
void set_field(Scene& scene, const std::string& path, const std::string& text);

/// The scene as a TOML file that read_scene takes.
[[nodiscard]] std::string to_toml(const Scene& scene);

/// The scene without what no pixel depends on: what is stored in pictures, which are the same whoever made them.
[[nodiscard]] Scene what_shows(Scene scene);

/// A flag of the command line for each field: its names ("--camera-fov-deg,--fov"), path, and help.
struct SceneFlag {
    std::string names, path, help;
    bool is_switch = false;  ///< yes or no
};
[[nodiscard]] std::vector<SceneFlag> scene_flags();

}  // namespace terravox
