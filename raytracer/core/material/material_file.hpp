#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "raytracer/core/material/appearance.hpp"

namespace terravox::material {

using MaterialAppearances = std::array<MaterialAppearance, voxel::kMaterialCount>;

/// The contents of a material file.
struct MaterialFile {
    MaterialAppearances appearances;
    /// Materials that the file does not name, without a table `default` that stands for them: they
    /// get the plain colour of `unknown`.
    std::vector<std::string> missing;
};

/// @param name empty: config/materials.toml; NAME: config/materials-NAME.toml; or a path, which
/// ends in .toml
/// @throws UsageError naming the files that exist
[[nodiscard]] std::filesystem::path find_materials(const std::string& name);

/// @throws UsageError naming file, material, field, value and allowed range; also for unknown
/// materials and fields
[[nodiscard]] MaterialFile read_materials(const std::filesystem::path& file);

/// The same for a text.
/// @param name used in messages
[[nodiscard]] MaterialFile parse_materials(const std::string& text, const std::string& name);

}  // namespace terravox::material
