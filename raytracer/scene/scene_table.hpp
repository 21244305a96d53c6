#pragma once

#include <toml++/toml.h>

#include <string>
#include <vector>

#include "raytracer/scene/scene.hpp"

namespace terravox::scene {

/// Reads the sections of a scene out of a table over `scene`: fields that it does not name stay as
/// they are.
/// @param attempt what is being done, begins every message @throws UsageError naming field, value
/// and allowed range, for unknown fields too
void read_scene_table(const toml::table& sections, const std::string& attempt, Scene& scene);

/// "section.field" of everything that stands in the sections of a table, sorted.
[[nodiscard]] std::vector<std::string> scene_paths(const toml::table& sections);

}  // namespace terravox::scene
