#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace terravox::minecraft {

/// The contents of level.dat. What it lacks is empty.
struct LevelDat {
    std::string name;                          ///< UTF-8
    std::string version;                       ///< e.g. "1.16.4"
    std::optional<std::int64_t> data_version;  ///< e.g. 2584; since 1.9
    std::optional<std::array<std::int64_t, 3>> spawn;
    std::optional<std::int64_t> seed;
};

/// @param file gzip, zlib or bare NBT
/// @param origin names it in messages
/// @throws Error
[[nodiscard]] LevelDat read_level_dat(std::span<const std::uint8_t> file,
                                      const std::string& origin);

}  // namespace terravox::minecraft
