#pragma once

#include <toml++/toml.h>

#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "raytracer/scene/scene.hpp"

namespace terravox::scene {

/// A part of a scene that has a name: where to stand to see something.
struct NamedView {
    std::string name, title;
    std::vector<std::string> aliases;
    std::string area;  ///< of config/areas, whose data show it; may be empty
    std::filesystem::path file;
    toml::table fields;  ///< sections of a scene
};

/// The views of a file. @throws UsageError naming file and view, for what is no field of a scene
/// too
[[nodiscard]] std::vector<NamedView> read_views(const std::filesystem::path& file);

/// The views of all .toml files of a folder, in the order of their names; none for a folder that is
/// not there.
[[nodiscard]] std::vector<NamedView> read_view_folder(const std::filesystem::path& folder);

/// The view of that name or alias, in any case and with any of blank, hyphen and underscore between
/// words.
/// @param look a name, or the path of a file with a single view (it ends in .toml or holds a slash)
/// @param folder where named ones are
/// @throws UsageError naming the views that come near, or all
[[nodiscard]] NamedView find_view(const std::string& look, const std::filesystem::path& folder);

/// Something that says something about a scene, over what was said before. May be called more than
/// once.
using SceneLayer = std::function<void(Scene&)>;
/// A scene file; an empty path says nothing.
[[nodiscard]] SceneLayer file_layer(std::filesystem::path file);
/// Path and text, as on the command line.
[[nodiscard]] SceneLayer fields_layer(std::vector<std::pair<std::string, std::string>> fields);

/// A scene out of its defaults, then the view that camera.look names (any layer may), then the
/// layers, the later over the earlier.
/// @param views folder of named views; empty: config/views @throws UsageError
[[nodiscard]] Scene compose_scene(const std::vector<SceneLayer>& layers,
                                  const std::filesystem::path& views = {});

}  // namespace terravox::scene
