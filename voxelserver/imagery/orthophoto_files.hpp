#pragma once

#include <filesystem>
#include <vector>

namespace terravox::imagery {

/// The images that paths name, and those in the folders that they name.
/// @throws UsageError for a path that does not exist
[[nodiscard]] std::vector<std::filesystem::path> orthophoto_files(
    const std::vector<std::filesystem::path>& paths);

}  // namespace terravox::imagery
