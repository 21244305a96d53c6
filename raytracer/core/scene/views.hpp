#pragma once

#include <toml++/toml.h>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "raytracer/core/scene/scene.hpp"

namespace terravox::scene {

/// A name in the form used for comparison: lower case (ASCII, and the Latin letters of two bytes in
/// UTF-8), words separated by one blank.
[[nodiscard]] std::string folded(const std::string& name);

/// The names that may have been meant: nearly the same, or one contains the other; the nearest
/// first, at most `max`.
[[nodiscard]] std::vector<std::string> near_names(const std::string& asked,
                                                  const std::vector<std::string>& names,
                                                  std::size_t max = 5);

/// Reads the sections of a scene from a table over `scene`: fields that are not in the table keep
/// their values.
/// @param attempt description of the operation, begins every message
/// @throws UsageError naming field, value and allowed range, also for unknown fields
void read_scene_table(const toml::table& sections, const std::string& attempt, Scene& scene);

/// "section.field" of every entry in the sections of a table, sorted.
[[nodiscard]] std::vector<std::string> scene_paths(const toml::table& sections);

/// A part of a scene that has a name: where to stand to see something.
struct NamedView {
    std::string name;
    std::string title;
    std::vector<std::string> aliases;
    std::string area;  ///< of config/areas, whose data contain what it shows; may be empty
    std::filesystem::path file;
    toml::table fields;  ///< sections of a scene
};

/// The views of a file.
/// @throws UsageError naming file and view, also for an unknown field of a scene
[[nodiscard]] std::vector<NamedView> read_views(const std::filesystem::path& file);

/// The views of all .toml files of a folder, in the order of their names; none if the folder does
/// not exist.
[[nodiscard]] std::vector<NamedView> read_view_folder(const std::filesystem::path& folder);

/// Finds the view of that name or alias; case is ignored, and blank, hyphen and underscore between
/// words are equivalent.
/// @param look a name, or the path of a file with a single view (it ends in .toml or holds a slash)
/// @param folder that contains the named views
/// @throws UsageError naming similar views, or all
[[nodiscard]] NamedView find_view(const std::string& look, const std::filesystem::path& folder);

/// Sets fields of a scene over those set before. May be called more than once.
using SceneLayer = std::function<void(Scene&)>;
/// The fields of a scene file; none for an empty path.
[[nodiscard]] SceneLayer file_layer(std::filesystem::path file);
/// Fields given as path and text, as on the command line.
[[nodiscard]] SceneLayer fields_layer(std::vector<std::pair<std::string, std::string>> fields);

/// The fields that a scene file and a view state, whatever values they have there: "section.field".
/// @param file empty: none
/// @param look as Scene::Camera::look
/// @param views as for compose_scene()
/// @throws UsageError as compose_scene()
[[nodiscard]] std::vector<std::string> stated_fields(const std::filesystem::path& file,
                                                     const std::string& look,
                                                     const std::filesystem::path& views = {});

/// Composes a scene from the defaults, then the view that camera.look names (any layer may set it),
/// then the layers, later ones overriding earlier ones.
/// @param views folder of named views; empty: config/views
/// @throws UsageError
[[nodiscard]] Scene compose_scene(const std::vector<SceneLayer>& layers,
                                  const std::filesystem::path& views = {});

}  // namespace terravox::scene
