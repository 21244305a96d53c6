#pragma once

#include <toml++/toml.h>

#include <string>
#include <vector>

#include "raytracer/core/scene/scene.hpp"

namespace terravox::scene {

/// Reads the sections of a scene from a table over `scene`: fields that are not in the table keep
/// their values.
/// @param attempt description of the operation, begins every message
/// @throws UsageError naming field, value and allowed range, also for unknown fields
void read_scene_table(const toml::table& sections, const std::string& attempt, Scene& scene);

/// "section.field" of every entry in the sections of a table, sorted.
[[nodiscard]] std::vector<std::string> scene_paths(const toml::table& sections);

}  // namespace terravox::scene
