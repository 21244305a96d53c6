#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "raytracer/core/scene/scene.hpp"

namespace terravox::farm {

using IsOutput = std::function<bool(const std::filesystem::path& file)>;

/// Identifies the inputs of a picture by their contents, one line each, so that a checkpoint, or a
/// finished frame, is recognised as that of its picture, on another machine too: the inputs, the
/// orthophotos, and the data files that affect voxels and looks (material file, classes, palettes,
/// blocks, voxelize.toml).
///   a file or folder   its name without the folder that contains it, files, bytes, and a hash: of
///                      names, sizes, and the first and the last 16 KiB of each file, where formats
///                      keep counts, times and indices. That takes two reads per file, however
///                      large. Hidden files and locks are ignored.
///   anything else      unchanged: an address, "generated:7"
/// @param is_output whether a file in a folder of inputs is ignored, since the program writes it
/// itself; called with the file's canonical path
/// @throws Error for a file that cannot be read
[[nodiscard]] std::vector<std::string> name_inputs(
    const std::vector<std::string>& inputs, const std::vector<std::filesystem::path>& orthophotos,
    const scene::Scene& scene, const IsOutput& is_output = {});

}  // namespace terravox::farm
