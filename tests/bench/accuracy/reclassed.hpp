#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace terravox::bench {

/// Copies LiDAR files with the points of one class put into another, like a survey that does not
/// distinguish the two. Coordinates, classes and colours are kept, which is all that voxels
/// are made of.
/// @param folder gets files of the same names; those that are there already are left as they are
/// @return the copies @throws Error
[[nodiscard]] std::vector<std::filesystem::path> reclass(
    const std::vector<std::filesystem::path>& files, std::uint8_t from, std::uint8_t to,
    const std::filesystem::path& folder);

}  // namespace terravox::bench
