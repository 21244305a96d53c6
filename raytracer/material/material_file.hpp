#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "raytracer/material/look.hpp"

namespace terravox::material {

using Looks = std::array<Look, voxel::kMaterialCount>;

/// What a material file says.
struct MaterialFile {
    Looks looks;
    std::vector<std::string>
        missing;  ///< materials that it does not name: they have the colour of `unknown`, plain
};

/// @param name empty: config/materials.toml; NAME: config/materials-NAME.toml; or a path, which
/// ends in .toml
/// @throws UsageError naming what there is
[[nodiscard]] std::filesystem::path find_materials(const std::string& name);

/// @throws UsageError naming file, material, field, value and allowed range; also for a material or
/// a field that nobody knows
[[nodiscard]] MaterialFile read_materials(const std::filesystem::path& file);

/// The same of a text that came another way. @param name for messages
[[nodiscard]] MaterialFile parse_materials(const std::string& text, const std::string& name);

}  // namespace terravox::material
