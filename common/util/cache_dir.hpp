#pragma once

#include <filesystem>
#include <string>

namespace terravox::util {

/// The folder for what can be made again but takes time.
/// @param given  "" = $XDG_CACHE_HOME/terravox, or ~/.cache/terravox; "none" = nothing is kept;
/// else a folder
/// @return empty when nothing is kept, or there is neither variable nor home
[[nodiscard]] std::filesystem::path cache_dir(const std::string& given);

}  // namespace terravox::util
