#pragma once

#include <filesystem>
#include <string>

namespace terravox::luanti {

/// The parts of a world that are read.
struct WorldFiles {
    std::filesystem::path map;  ///< map.sqlite
    std::string title;          ///< world.mt's, else the name of the folder
    std::string game;           ///< world.mt's gameid; may be empty
};

/// Whether `path` is a world's folder (it has a world.mt, and no level.dat of Minecraft), or a file
/// named map.sqlite. Never throws.
[[nodiscard]] bool looks_like_luanti(const std::filesystem::path& path) noexcept;

/// @param path as looks_like_luanti()
/// @throws UsageError for a world whose map is not in an SQLite file, or has blocks of another
/// size; Error when world.mt cannot be read
[[nodiscard]] WorldFiles find_world_files(const std::filesystem::path& path);

}  // namespace terravox::luanti
