#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "raytracer/scene/scene.hpp"

namespace terravox::farm {

/// Names what a picture is made from by its contents, a line each, so that checkpoints know their
/// picture again, on another machine as well: the inputs, the orthophotos, and the data files that
/// shape voxels and looks (material file, classes, palettes, blocks, voxelize.toml).
///   a file or folder   its name without the folder that it lies in, files, bytes, and a hash: of
///   names, sizes, and the first and the last 16 KiB
///                      of each file, where formats keep counts, times and indices. Two reads a
///                      file, however large. Hidden files and locks count for nothing.
///   anything else      as it is: an address, "generated:7"
/// @throws Error for a file that cannot be read
[[nodiscard]] std::vector<std::string> name_inputs(
    const std::vector<std::string>& inputs, const std::vector<std::filesystem::path>& orthophotos,
    const scene::Scene& scene);

}  // namespace terravox::farm
