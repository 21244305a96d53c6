#pragma once

#include <filesystem>
#include <string>

namespace terravox::util {

/// The folder for data that can be recomputed, but at a cost.
/// @param given  "" = $XDG_CACHE_HOME/terravox, or ~/.cache/terravox; "none" = nothing is cached;
/// else a folder
/// @return empty when nothing is cached, or when neither the variable nor a home folder exists
[[nodiscard]] std::filesystem::path cache_dir(const std::string& given);

}  // namespace terravox::util
