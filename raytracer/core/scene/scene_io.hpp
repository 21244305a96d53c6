#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "raytracer/core/scene/scene.hpp"

namespace terravox::scene {

inline constexpr int kSceneVersion = 1;

/// Reads a scene file over `scene`: fields that are not in the file keep their values.
/// @throws UsageError naming file, field, value and allowed range, also for unknown fields
void read_scene(const std::filesystem::path& file, Scene& scene);

/// The same for a text.
/// @param name used in messages
void parse_scene(const std::string& text, const std::string& name, Scene& scene);

/// Sets one field from text, as on the command line.
/// @param path "section.field"
/// @throws UsageError naming field, value and allowed range
void set_field(Scene& scene, const std::string& path, const std::string& text);

/// What set_field() would refuse, whatever the scene: for a message that names the flag.
/// @param flag "--camera-fov-deg"
/// @return "--camera-fov-deg = 'wide'; allowed: a number"; "" for a value that the field may have
[[nodiscard]] std::string find_fault(const std::string& path, const std::string& text,
                                     const std::string& flag);

/// The scene as a TOML file that read_scene takes.
[[nodiscard]] std::string to_toml(const Scene& scene);

/// The value of a field in the form of the command line (set_field).
struct FieldText {
    std::string path;
    std::optional<std::string> text;  ///< none: not set
    friend bool operator==(const FieldText&, const FieldText&) = default;
};
/// All fields, in the order of the list.
[[nodiscard]] std::vector<FieldText> field_texts(const Scene& scene);
/// The fields whose values differ from those of another scene.
[[nodiscard]] std::vector<FieldText> changed_fields(const Scene& scene, const Scene& from);
/// The flag of a field: "--camera-fov-deg".
[[nodiscard]] std::string find_flag(std::string_view path);

/// The scene without the fields that no pixel depends on: this is stored in pictures, which are the
/// same however they were made.
[[nodiscard]] Scene what_shows(Scene scene);

/// A command-line flag for a field: its names ("--camera-fov-deg,--fov"), path, and help.
struct SceneFlag {
    std::string names;
    std::string path;
    std::string help;
    std::string former;      ///< its name before it was renamed, or empty
    bool is_switch = false;  ///< yes or no
};
[[nodiscard]] std::vector<SceneFlag> scene_flags();

}  // namespace terravox::scene
