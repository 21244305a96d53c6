#pragma once

#include <filesystem>
#include <vector>

namespace terravox::imagery {

/// Expands the given paths to image files, replacing folders by the images in them.
/// @throws UsageError for a path that does not exist
[[nodiscard]] std::vector<std::filesystem::path> orthophoto_files(
    const std::vector<std::filesystem::path>& paths);

}  // namespace terravox::imagery
